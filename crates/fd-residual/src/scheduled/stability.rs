//! Whether the estimation error dies out at every operating point, and under changes of any speed.

use faer::{Mat, Scale};
use fd_model::lyapunov;
use fd_numeric::dense::DenseReal;

use crate::kalman::symmetric;

/// Whether a common quadratic function decreases for all of these.
///
/// Tried are the solutions of Stein's equation for each of the matrices, for their mean, and the sum of all: enough where
/// the matrices are near each other, and no proof of the contrary where it is not.
pub(super) fn common_lyapunov(all: &[Mat<f64>]) -> bool {
    let Some(n) = all.first().map(Mat::nrows) else { return true };
    let one = Mat::<f64>::identity(n, n);
    let share = Scale((all.len() as f64).recip());
    let mean = all.iter().fold(Mat::zeros(n, n), |sum: Mat<f64>, f| sum + share * f);
    let of = |f: &Mat<f64>| lyapunov::discrete(f.transpose(), one.as_ref()).ok();
    let mut tried: Vec<Mat<f64>> = std::iter::once(&mean).chain(all).filter_map(of).collect();
    let size = |p: &Mat<f64>| p.norm_l2().recip();
    let sum = tried.iter().fold(Mat::zeros(n, n), |sum: Mat<f64>, p| sum + Scale(size(p)) * p);
    tried.push(sum);
    tried.iter().any(|p| all.iter().all(|f| decreases(p, f)))
}

fn decreases(p: &Mat<f64>, f: &Mat<f64>) -> bool {
    // More than rounding of the product.
    const CLEAR: f64 = 1e-12;
    let drop = symmetric(&(p - f.transpose() * p * f));
    let least = |m: &Mat<f64>| {
        let values = m.symmetric_eigenvalues().ok();
        values.and_then(|values| values.first().copied())
    };
    least(&drop).is_none_or(|value| CLEAR * p.norm_l2() < value)
}
