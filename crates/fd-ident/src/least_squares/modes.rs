//! Singular values of a small triangular factor, whatever it is like.

use faer::{Mat, MatRef};
use fd_numeric::dense::Dense;

use crate::error::IdentError;

/// Most sweeps of Jacobi's method; some ten are enough for any matrix of this size.
const SWEEPS: usize = 60;

/// `R = U diag(σ) Vᵀ`, the largest singular value first.
pub(super) struct Modes {
    pub u: Mat<f64>,
    pub sigma: Vec<f64>,
    pub v: Mat<f64>,
}

impl Modes {
    /// By bidiagonalisation or, where that does not converge, by Jacobi's method.
    ///
    /// # Errors
    ///
    /// Returns an error when neither does, as with a value that is not finite.
    pub(super) fn of(r: MatRef<'_, f64>) -> Result<Self, IdentError> {
        match r.economic_svd() {
            Ok(svd) => Ok(Self {
                u: svd.U().to_owned(),
                sigma: svd.S().column_vector().iter().copied().collect(),
                v: svd.V().to_owned(),
            }),
            Err(_) => Self::by_rotations(r),
        }
    }

    /// One-sided Jacobi rotations (Demmel and Veselić 1992): columns are turned against each other until all are
    /// orthogonal; their lengths are the singular values.
    fn by_rotations(r: MatRef<'_, f64>) -> Result<Self, IdentError> {
        let (rows, n) = (r.nrows(), r.ncols());
        let (mut w, mut v) = (r.to_owned(), Mat::<f64>::identity(n, n));
        let tolerance = 4.0 * f64::EPSILON;
        // A column this short is the rounding of others, and never orthogonal to them.
        let nothing = (tolerance * r.norm_l2()).powi(2);
        let mut left = true;
        for _ in 0..SWEEPS {
            left = false;
            for p in 0..n {
                for q in p + 1..n {
                    let dot = |i: usize, j: usize| w.col(i).transpose() * w.col(j);
                    let (a, b, c) = (dot(p, p), dot(q, q), dot(p, q));
                    if c.is_nan() {
                        return Err(unfit());
                    }
                    if c.abs() <= tolerance * (a * b).sqrt() || a.min(b) <= nothing {
                        continue;
                    }
                    left = true;
                    let zeta = (b - a) / (2.0 * c);
                    let t = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
                    let cosine = t.hypot(1.0).recip();
                    turn(&mut w, (p, q), cosine, cosine * t);
                    turn(&mut v, (p, q), cosine, cosine * t);
                }
            }
            if !left {
                break;
            }
        }
        if left {
            return Err(unfit());
        }
        let lengths: Vec<f64> = (0..n).map(|j| w.col(j).norm_l2()).collect();
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|a, b| lengths[*b].total_cmp(&lengths[*a]));
        let sigma: Vec<f64> = order.iter().map(|&j| lengths[j]).collect();
        let unit =
            |i: usize, j: usize| if sigma[j] > 0.0 { w[(i, order[j])] / sigma[j] } else { 0.0 };
        let u = Mat::from_fn(rows, n, unit);
        let v = Mat::from_fn(n, n, |i, j| v[(i, order[j])]);
        Ok(Self { u, sigma, v })
    }
}

fn unfit() -> IdentError {
    IdentError::NoConvergence { what: "singular values of R" }
}

fn turn(m: &mut Mat<f64>, (p, q): (usize, usize), cosine: f64, sine: f64) {
    for i in 0..m.nrows() {
        let (a, b) = (m[(i, p)], m[(i, q)]);
        m[(i, p)] = cosine * a - sine * b;
        m[(i, q)] = sine * a + cosine * b;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rotations give what bidiagonalisation gives, also where columns depend on each other.
    #[test]
    fn rotations_find_the_same_modes() {
        let r = Mat::from_fn(5, 5, |i, j| {
            let j = if j == 4 { 1 } else { j };
            if i <= j {
                10.0_f64.powf(-(i as f64)) * (1.0 + ((i * 7 + j * 3) % 5) as f64)
            } else {
                0.0
            }
        });
        let (a, b) = (Modes::of(r.as_ref()).unwrap(), Modes::by_rotations(r.as_ref()).unwrap());
        for (a, b) in a.sigma.iter().zip(&b.sigma) {
            // Both to some roundings of the largest.
            assert!((a - b).abs() < 1e-14 * b.max(10.0), "{a} {b}");
        }
        let again = Mat::from_fn(5, 5, |i, j| {
            (0..5).map(|k| b.u[(i, k)] * b.sigma[k] * b.v[(j, k)]).sum::<f64>()
        });
        assert!((again - &r).norm_max() < 1e-14, "U Σ Vᵀ is R");
        let bad = Mat::from_fn(2, 2, |_, _| f64::NAN);
        assert!(Modes::by_rotations(bad.as_ref()).is_err());
    }
}
