//! Stationary filters on either time axis, with correlated noises.

use faer::{Mat, MatRef, Scale, prelude::Solve};
use fd_model::{ModelError, TimeDomain, riccati as discrete_riccati};
use fd_numeric::dense::{Dense, DenseReal};

use crate::{
    error::DesignError,
    matrix::{blocks, spectral_norm},
};

/// Steps of Newton's iteration for the matrix sign; some ten are usual.
const STEPS: usize = 100;

/// Noise that drives the states (`q`), the outputs (`r`), and what they have in common (`s`,
/// states × outputs).
pub(crate) struct Noises {
    pub q: Mat<f64>,
    pub s: Mat<f64>,
    pub r: Mat<f64>,
}

/// A stationary filter.
pub(crate) struct Filter {
    /// `L` in `x̂⁺ = A x̂ + L (y − C x̂)`.
    pub gain: Mat<f64>,
    /// Covariance (or intensity) of the innovation `y − C x̂`.
    pub innovation: Mat<f64>,
}

/// The filter of `x⁺ = A x + w`, `y = C x + v` with the given noises, `R > 0`.
///
/// # Errors
///
/// Returns an error when `R` is singular, or no stabilising solution exists.
pub(crate) fn filter<D: TimeDomain>(
    domain: D,
    a: MatRef<'_, f64>,
    c: MatRef<'_, f64>,
    noises: &Noises,
) -> Result<Filter, DesignError> {
    let Noises { q, s, r } = noises;
    if a.nrows() == 0 {
        return Ok(Filter { gain: Mat::zeros(0, c.nrows()), innovation: r.clone() });
    }
    // Feeding S R⁻¹ (y − C x) into the states leaves noises that are independent.
    let inverse = r.lu().solve(Mat::<f64>::identity(r.nrows(), r.nrows()));
    if !inverse.norm_max().is_finite() {
        return Err(ModelError::Singular { role: "measurement noise R" }.into());
    }
    let common = s * &inverse;
    let free = a - &common * c;
    let rest = symmetric(&(q - &common * s.transpose()));
    let (gain, innovation, what) = if domain.highest_frequency().is_finite() {
        match discrete_riccati::discrete_filter(free.as_ref(), c, rest.as_ref(), r.as_ref()) {
            // Doubling finds the least solution, which is not the stabilising one when no noise
            // drives a growing mode; such are the zeros of a noise filter outside the circle. What
            // is then left of Q is zero but for rounding, of either sign.
            Err(ModelError::NotStabilisable { .. } | ModelError::NotPositive { .. }) => {
                let p = discrete(&free, &(c.transpose() * &inverse * c), &rest)?;
                let innovation = r + c * &p * c.transpose();
                let gain = innovation.lu().solve(c * &p * free.transpose());
                (gain.transpose() + common, innovation, "the discrete filter")
            }
            found => {
                let found = found?;
                return Ok(Filter { gain: found.gain + common, innovation: found.weight });
            }
        }
    } else {
        let p = riccati(&free, &(c.transpose() * &inverse * c), &rest)?;
        ((p * c.transpose() + s) * inverse, r.clone(), "the continuous filter")
    };
    let (closed, order) = (a - &gain * c, a.nrows());
    let modes = closed.modes().map_err(|_| ModelError::NoConvergence { what, order })?;
    match modes.iter().find(|&&mode| !domain.decays(mode)) {
        Some(mode) => Err(ModelError::NotStabilisable { what, re: mode.re, im: mode.im }.into()),
        None => Ok(Filter { gain, innovation }),
    }
}

/// A gain with which every mode of `A − L C` dies out at least as fast as `rate` (1/s): the
/// filter of a plant whose modes are slowed down by it (Anderson and Moore 1971, section 4.1).
pub(crate) fn at_least_as_fast<D: TimeDomain>(
    domain: D,
    a: MatRef<'_, f64>,
    c: MatRef<'_, f64>,
    pole: f64,
) -> Result<Mat<f64>, DesignError> {
    let (n, ny) = (a.nrows(), c.nrows());
    let or_one = |size: f64| if 0.0 < size { size } else { 1.0 };
    // Outputs of unit size; of states nothing is known.
    let size: Vec<f64> = (0..ny).map(|i| or_one(c.row(i).norm_l2())).collect();
    let unit = Mat::from_fn(ny, n, |i, j| c[(i, j)] / size[i]);
    let sampled = domain.highest_frequency().is_finite();
    let one = Mat::<f64>::identity(n, n);
    let (slowed, back, drive) = if sampled {
        (Scale(pole.recip()) * a, pole, 1.0)
    } else {
        // pole < 0; noise that moves the filter about as fast as that.
        (a - Scale(pole) * &one, 1.0, (pole * pole).max(spectral_norm(a).powi(2)))
    };
    let noises = Noises { q: Scale(drive) * one, s: Mat::zeros(n, ny), r: Mat::identity(ny, ny) };
    let found = filter(domain, slowed.as_ref(), unit.as_ref(), &noises)?;
    Ok(Mat::from_fn(n, ny, |i, j| back * found.gain[(i, j)] / size[j]))
}

/// The stabilising solution of `A P + P Aᵀ − P G P + Q = 0`; `G` may be indefinite.
pub(crate) fn riccati(a: &Mat<f64>, g: &Mat<f64>, q: &Mat<f64>) -> Result<Mat<f64>, DesignError> {
    let minus = Scale(-1.0);
    decaying(blocks(&[
        &[a.transpose(), (minus * g).as_ref()],
        &[(minus * q).as_ref(), (minus * a).as_ref()],
    ]))
}

/// The stabilising solution of `P = A P (I + G P)⁻¹ Aᵀ + Q`: the symplectic pencil of the equation
/// has the invariant subspaces of its image under `s = (z − 1)/(z + 1)`.
fn discrete(a: &Mat<f64>, g: &Mat<f64>, q: &Mat<f64>) -> Result<Mat<f64>, DesignError> {
    let n = a.nrows();
    let (one, none) = (Mat::<f64>::identity(n, n), Mat::<f64>::zeros(n, n));
    let minus_q = Scale(-1.0) * q;
    let left = blocks(&[&[a.transpose(), none.as_ref()], &[minus_q.as_ref(), one.as_ref()]]);
    let right = blocks(&[&[one.as_ref(), g.as_ref()], &[none.as_ref(), a.as_ref()]]);
    decaying((&left + &right).lu().solve(&left - &right))
}

/// `P` such that `[I; P]` spans the decaying modes of a Hamiltonian matrix, from the matrix's sign
/// (Roberts 1980).
fn decaying(mut z: Mat<f64>) -> Result<Mat<f64>, DesignError> {
    let n = z.nrows() / 2;
    let failed = || {
        let what = "the stationary filter";
        DesignError::from(ModelError::NoConvergence { what, order: n })
    };
    for _ in 0..STEPS {
        let inverse = z.lu().solve(Mat::<f64>::identity(2 * n, 2 * n));
        let scale = (inverse.norm_l2() / z.norm_l2()).sqrt();
        if !(0.0 < scale && scale.is_finite()) {
            return Err(failed());
        }
        let next = Scale(0.5 * scale) * &z + Scale(0.5 / scale) * inverse;
        let change = (&next - &z).norm_l2();
        z = next;
        if change <= 1e-14 * z.norm_l2() * (2.0 * n as f64) {
            break;
        }
    }
    if !z.norm_max().is_finite() {
        return Err(failed());
    }
    let one = Mat::<f64>::identity(n, n);
    let tall = blocks(&[&[z.submatrix(0, n, n, n)], &[(z.submatrix(n, n, n, n) + &one).as_ref()]]);
    let right = blocks(&[&[(z.submatrix(0, 0, n, n) + &one).as_ref()], &[z.submatrix(n, 0, n, n)]]);
    let svd = tall.economic_svd().map_err(|_| failed())?;
    Ok(symmetric(&(Scale(-1.0) * (svd.pseudoinverse() * right))))
}

/// The symmetric part, which rounding has left.
pub(crate) fn symmetric(m: &Mat<f64>) -> Mat<f64> {
    Scale(0.5) * (m + m.transpose())
}
