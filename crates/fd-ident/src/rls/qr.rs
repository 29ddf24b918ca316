//! Recursive least squares on the triangular factor of the information, for comparison.

use fd_core::{
    Buffer, Heap, Scalar, Shape, StateVisitor,
    stage::{GuardReport, Stage},
};
use fd_numeric::dot;

use crate::{
    error::IdentError,
    rls::{
        RlsKernel,
        forgetting::{Falling, Forgetting, RlsDesign},
        storage::{Grid, RlsStorage},
    },
};

/// `P⁻¹ = RᵀR` with `R` upper triangular, renewed by Givens rotations (Gentleman 1973).
///
/// The rotations are orthogonal, so this is as accurate as a QR factorisation of all weighted
/// samples at once: what other forms are judged by. With the innovation `e` in place of the
/// target, `[R 0; φᵀ e]` is rotated into `[R⁺ z; 0 ·]`, and the estimate moves by `R⁺⁻¹ z`.
///
/// Directional forgetting then takes `(1−λ)/φᵀP⁺φ · φφᵀ` from `R⁺ᵀR⁺` at the same estimate, by
/// rotations again: with `p` the solution of `R⁺ᵀp = φ`, scaled to `pᵀp = 1 − λ`, those that turn
/// `[p; √λ]` into `[0; 1]` turn `[R⁺; 0]` into what is left and the row that is taken out.
///
/// # When not to use it
///
/// In production: each sample costs a square root and a division per parameter and a
/// back-substitution, the information is lost when excitation stops, and nothing guards against
/// it. Use [`UdRls`](crate::rls::UdRls).
///
/// # Examples
///
/// ```
/// use fd_ident::rls::{QrRls, RlsDesign, RlsKernel, Static};
///
/// let mut rls = QrRls::<f64, Static<2>>::new(2, &RlsDesign::default())?;
/// let mut theta = [0.0; 2];
/// for (phi, y) in [([1.0, 0.0], 2.0), ([1.0, 1.0], 1.0), ([0.0, 3.0], -3.0)] {
///     rls.update(&phi, y, &mut theta);
/// }
/// assert!((theta[0] - 2.0).abs() < 1e-5 && (theta[1] + 1.0).abs() < 1e-5);
/// # Ok::<(), fd_ident::IdentError>(())
/// ```
#[derive(Clone, Debug)]
pub struct QrRls<T: Scalar = f64, S: RlsStorage<T> = Heap> {
    /// `α(k)` of eq. (18), else 1: a new sample has the weight `1/α`.
    alpha: T,
    designed_alpha: T,
    falling: Option<Falling<T>>,
    /// Square root of the weight of what is known.
    memory: T,
    designed_memory: T,
    prior: T,
    /// `√λ` of directional forgetting, else 1.
    kept: T,
    /// `R`, row by row; below the diagonal it stays zero.
    r: S::Square,
    /// The new row, which is rotated into `R`.
    row: S::Parameters,
    z: S::Parameters,
    skipped: u64,
}

impl<T: Scalar, S: RlsStorage<T>> QrRls<T, S> {
    /// An estimator of `n` parameters. The guard of the design is not used.
    ///
    /// # Errors
    ///
    /// Returns an error when a setting is out of range, the kind of forgetting is `Bounded` or
    /// `Resetting`, or the storage is fixed and has another size.
    pub fn new(n: usize, design: &RlsDesign) -> Result<Self, IdentError> {
        design.check()?;
        let (alpha, memory, kept) = match design.forgetting {
            Forgetting::None => (1.0, 1.0, 1.0),
            Forgetting::Equation18 { alpha, .. } => (alpha, 1.0, 1.0),
            Forgetting::Exponential { lambda } => (1.0, lambda.sqrt(), 1.0),
            Forgetting::Directional { lambda } => (1.0, 1.0, lambda.sqrt()),
            Forgetting::Bounded { lambda, .. } | Forgetting::Resetting { lambda, .. } => {
                return Err(IdentError::Setting {
                    setting: "forgetting factor of kind bounded or resetting, on QR,",
                    expected: "absent",
                    found: lambda,
                });
            }
        };
        let mut rls = Self {
            alpha: T::from_design(alpha),
            designed_alpha: T::from_design(alpha),
            falling: match design.forgetting.freeze() {
                Forgetting::Equation18 { falling, .. } => falling,
                _ => None,
            },
            memory: T::from_design(memory),
            designed_memory: T::from_design(memory),
            prior: T::from_design(design.prior_variance.sqrt().recip()),
            kept: T::from_design(kept),
            r: S::Square::zeros("information factor R", Shape::new(n, n))?,
            row: S::Parameters::zeros("row to rotate", n)?,
            z: S::Parameters::zeros("rotated innovation", n)?,
            skipped: 0,
        };
        rls.reset();
        Ok(rls)
    }

    /// Weighs what is known by `√λ = memory` for the next samples: for a forgetting that somebody
    /// else decides about.
    pub fn set_memory(&mut self, memory: T) {
        self.memory = memory;
    }

    /// Sum of the variances of the parameters, relative to a noise of variance 1.
    pub fn trace(&self) -> T {
        let n = self.z.as_ref().len();
        let mut column = self.z.clone();
        (0..n).fold(T::zero(), |trace, j| {
            self.column_of_inverse(j, column.as_mut());
            trace + dot(&column.as_ref()[..=j], &column.as_ref()[..=j])
        })
    }

    /// Condition `‖R‖ ‖R⁻¹‖` of the weighted regressors, in Frobenius norms.
    pub fn condition(&self) -> T {
        let r = self.r.as_slice();
        (dot(r, r) * self.trace()).sqrt()
    }

    /// Forgets along `φ`.
    fn forget_along(&mut self, phi: &[T]) {
        let (r, p, n) = (self.r.as_mut_slice(), self.row.as_mut(), phi.len());
        for i in 0..n {
            let sum = (0..i).fold(phi[i], |sum, k| sum - r[k * n + i] * p[k]);
            p[i] = sum / r[i * n + i];
        }
        let energy = dot(p, p);
        if energy <= T::zero() {
            return;
        }
        let factor = ((T::one() - self.kept * self.kept) / energy).sqrt();
        let mut rest = self.kept;
        // The row that is taken out, so far.
        let out = self.z.as_mut();
        out.fill(T::zero());
        for i in (0..n).rev() {
            let entry = factor * p[i];
            let length = (rest * rest + entry * entry).sqrt();
            let (c, s) = (rest / length, entry / length);
            rest = length;
            for (r, out) in r[i * n + i..(i + 1) * n].iter_mut().zip(&mut out[i..]) {
                let old = *r;
                *r = c * old - s * *out;
                *out = c * *out + s * old;
            }
        }
    }

    /// The first `j + 1` entries of column `j` of `R⁻¹`; the others are zero.
    fn column_of_inverse(&self, j: usize, column: &mut [T]) {
        let (r, n) = (self.r.as_slice(), column.len());
        column[j] = T::one() / r[j * n + j];
        for i in (0..j).rev() {
            let sum = dot(&r[i * n + i + 1..=i * n + j], &column[i + 1..=j]);
            column[i] = -sum / r[i * n + i];
        }
    }
}

impl<T: Scalar, S: RlsStorage<T>> RlsKernel<T> for QrRls<T, S> {
    fn parameters(&self) -> usize {
        self.z.as_ref().len()
    }

    fn update(&mut self, phi: &[T], target: T, theta: &mut [T]) {
        let n = self.parameters();
        let (phi, theta) = (&phi[..n], &mut theta[..n]);
        let innovation = target - dot(phi, theta);
        if !innovation.is_finite() {
            self.skipped += 1;
            return;
        }
        let (r, row, z) = (self.r.as_mut_slice(), self.row.as_mut(), self.z.as_mut());
        let gain = self.alpha.sqrt().recip();
        row.iter_mut().zip(phi).for_each(|(row, &phi)| *row = gain * phi);
        let mut rest = gain * innovation;
        for i in 0..n {
            let line = &mut r[i * n..(i + 1) * n];
            let (a, b) = (self.memory * line[i], row[i]);
            let length = (a * a + b * b).sqrt();
            let (c, s) =
                if length > T::zero() { (a / length, b / length) } else { (T::one(), T::zero()) };
            line[i] = length;
            for (r, row) in line[i + 1..].iter_mut().zip(&mut row[i + 1..]) {
                let old = self.memory * *r;
                *r = c * old + s * *row;
                *row = c * *row - s * old;
            }
            z[i] = s * rest;
            rest *= c;
        }
        for i in (0..n).rev() {
            let line = &r[i * n..(i + 1) * n];
            z[i] = (z[i] - dot(&line[i + 1..], &z[i + 1..])) / line[i];
            theta[i] += z[i];
        }
        if self.kept < T::one() {
            self.forget_along(phi);
        }
        if let Some(falling) = self.falling {
            self.alpha = falling.after(self.alpha);
        }
    }

    /// The squared lengths of the rows of `R⁻¹`, each made where the variances after it will be.
    fn variance_into(&self, variance: &mut [T]) {
        let (r, n) = (self.r.as_slice(), self.parameters());
        for i in 0..n {
            variance[i] = r[i * n + i].recip();
            for j in i + 1..n {
                let sum = (i..j).fold(T::zero(), |sum, k| sum + variance[k] * r[k * n + j]);
                variance[j] = -sum / r[j * n + j];
            }
            variance[i] = dot(&variance[i..n], &variance[i..n]);
        }
    }

    fn guard(&self) -> GuardReport {
        GuardReport { skipped: self.skipped, bounded: 0 }
    }
}

impl<T: Scalar, S: RlsStorage<T>> Stage<T> for QrRls<T, S> {
    fn reset(&mut self) {
        let n = self.parameters();
        self.r.as_mut_slice().fill(T::zero());
        let prior = self.prior;
        self.r.as_mut_slice().iter_mut().step_by(n + 1).for_each(|r| *r = prior);
        self.memory = self.designed_memory;
        self.alpha = self.designed_alpha;
        self.skipped = 0;
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("information factor R", self.r.as_mut_slice());
        visitor.reals("memory", std::slice::from_mut(&mut self.memory));
        visitor.reals("alpha", std::slice::from_mut(&mut self.alpha));
        visitor.counts("skipped", std::slice::from_mut(&mut self.skipped));
    }
}
