//! The covariance as `U D Uᵀ`, which stays positive definite in any arithmetic.
#![expect(
    clippy::inline_always,
    reason = "inlined loops over indices are unrolled where the storage has a fixed size"
)]

use fd_core::{Buffer, Heap, Scalar, Shape, ShapeError, StateVisitor};
use fd_numeric::dot;

use crate::rls::{
    covariance::{Covariance, add_scaled, rounding},
    storage::{Grid, RlsStorage},
};

/// `P = U D Uᵀ` with `U` unit upper triangular and `D` diagonal (Bierman 1977).
///
/// Information is taken in by Bierman's update, given up by that of Agee and Turner. Both keep
/// every entry of `D` positive whatever the round-off, so the denominators of the gain cannot
/// become zero or negative. The error of `P` is that of a square root form: in `f32` it gives
/// about the digits that the conventional form gives in `f64`.
#[derive(Clone, Debug)]
pub struct Ud<T: Scalar, S: RlsStorage<T> = Heap> {
    /// Strict upper triangle of `U`, column by column; the rest stays zero.
    u: S::Square,
    d: S::Parameters,
    /// `f = Uᵀφ` of the remembered direction.
    f: S::Parameters,
}

impl<T: Scalar, S: RlsStorage<T>> Covariance<T> for Ud<T, S> {
    type Parameters = S::Parameters;

    fn isotropic(n: usize, variance: T) -> Result<Self, ShapeError> {
        let mut p = Self {
            u: S::Square::zeros("factor U", Shape::new(n, n))?,
            d: S::Parameters::zeros("factor D", n)?,
            f: S::Parameters::zeros("projected regressor", n)?,
        };
        p.restart(variance);
        Ok(p)
    }

    fn restart(&mut self, variance: T) {
        self.u.as_mut_slice().fill(T::zero());
        self.d.as_mut().fill(variance);
    }

    #[inline(always)]
    fn energy(&mut self, phi: &[T]) -> T {
        let (u, d, f) = (self.u.as_slice(), self.d.as_ref(), self.f.as_mut());
        let n = d.len();
        // One check of the length instead of one per entry.
        let phi = &phi[..n];
        let mut energy = T::zero();
        for j in 0..n {
            f[j] = phi[j];
            for i in 0..j {
                f[j] += u[j * n + i] * phi[i];
            }
            energy += f[j] * (d[j] * f[j]);
        }
        energy
    }

    fn ignore_rounding(&mut self, phi: &[T]) {
        let (u, f) = (self.u.as_slice(), self.f.as_mut());
        let n = f.len();
        for j in 0..n {
            let column = u[j * n..j * n + j].iter().zip(phi);
            let size = column.fold(phi[j].abs(), |size, (&u, &phi)| size + (u * phi).abs());
            if f[j].abs() <= rounding::<T>(n) * size {
                f[j] = T::zero();
            }
        }
    }

    #[inline(always)]
    fn learn(&mut self, weight: T, noise: T, scale: T, p_phi: &mut [T]) -> T {
        let (u, d, f) = (self.u.as_mut_slice(), self.d.as_mut(), self.f.as_ref());
        let n = d.len();
        let p_phi = &mut p_phi[..n];
        // a_j = ρ + w Σ_{i≤j} f_i d_i f_i, the innovation variance so far; never below ρ. Its
        // inverse is the one division of a column.
        let (mut before, mut inverse) = (noise, T::one());
        for j in 0..n {
            // What `energy` has computed: a compiler that sees both does not do it again.
            let g = d[j] * f[j];
            let factor = -(weight * f[j]) * inverse;
            let a = before + weight * (f[j] * g);
            inverse = T::one() / a;
            d[j] *= (scale * before) * inverse;
            for i in 0..j {
                let old = u[j * n + i];
                u[j * n + i] = old + factor * p_phi[i];
                p_phi[i] += old * g;
            }
            p_phi[j] = g;
            before = a;
        }
        inverse
    }

    fn release(&mut self, weight: T, remainder: T, p_phi: &mut [T]) {
        let (u, d, f) = (self.u.as_mut_slice(), self.d.as_mut(), self.f.as_mut());
        let n = d.len();
        for j in 0..n {
            let g = d[j] * f[j];
            add_scaled(&mut p_phi[..j], g, &u[j * n..j * n + j]);
            p_phi[j] = g;
        }
        // P + c v vᵀ with v = Pφ and c = w / (1 − w φᵀPφ); `f` now serves as a copy of v.
        f.copy_from_slice(p_phi);
        let mut c = weight / remainder;
        for j in (0..n).rev() {
            let old = d[j];
            let (rest, last) = f.split_at_mut(j);
            let s = last[0];
            d[j] = old + c * (s * s);
            let b = c * s / d[j];
            c *= old / d[j];
            for (u, v) in u[j * n..j * n + j].iter_mut().zip(rest) {
                *v -= s * *u;
                *u += b * *v;
            }
        }
    }

    fn scale(&mut self, factor: T) {
        self.d.as_mut().iter_mut().for_each(|d| *d *= factor);
    }

    fn trace(&self) -> T {
        let (u, d) = (self.u.as_slice(), self.d.as_ref());
        let n = d.len();
        (0..n).fold(T::zero(), |trace, j| {
            let column = &u[j * n..j * n + j];
            trace + d[j] * (T::one() + dot(column, column))
        })
    }

    fn diagonal_into(&self, diagonal: &mut [T]) {
        let (u, d) = (self.u.as_slice(), self.d.as_ref());
        let n = d.len();
        diagonal.copy_from_slice(d);
        for j in 0..n {
            for (p, &u) in diagonal.iter_mut().zip(&u[j * n..j * n + j]) {
                *p += d[j] * (u * u);
            }
        }
    }

    fn visit(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("factor U", self.u.as_mut_slice());
        visitor.reals("factor D", self.d.as_mut());
    }
}

impl<T: Scalar, S: RlsStorage<T>> Ud<T, S> {
    /// Computes `P ← P + diag(variances)`, one axis after the other by the update of Agee &
    /// Turner (1972), so that every entry of `D` stays positive. Costs O(n³).
    pub(crate) fn add_diagonal(&mut self, variances: &[T]) {
        let (u, d, v) = (self.u.as_mut_slice(), self.d.as_mut(), self.f.as_mut());
        let n = d.len();
        for (axis, &variance) in variances.iter().enumerate().take(n) {
            if variance <= T::zero() {
                continue;
            }
            v.fill(T::zero());
            v[axis] = T::one();
            let mut c = variance;
            for j in (0..=axis).rev() {
                let old = d[j];
                let (rest, last) = v.split_at_mut(j);
                let s = last[0];
                d[j] = old + c * (s * s);
                let b = c * s / d[j];
                c *= old / d[j];
                for (u, v) in u[j * n..j * n + j].iter_mut().zip(rest) {
                    *v -= s * *u;
                    *u += b * *v;
                }
            }
        }
    }
}
