//! Eigenvalues of covariances, largest first.

use faer::{Mat, MatRef};
use fd_numeric::dense::Dense;

use crate::error::DataError;

/// Eigenvalues, largest first, and the eigenvectors as columns in the same order.
#[derive(Clone, Debug)]
pub(crate) struct Spectrum {
    pub values: Vec<f64>,
    pub vectors: Mat<f64>,
}

impl Spectrum {
    /// Of a symmetric matrix that is not negative; what rounding made negative is zero.
    pub(crate) fn of(matrix: MatRef<'_, f64>, what: &'static str) -> Result<Self, DataError> {
        let n = matrix.nrows();
        let eigen = matrix.symmetric_eigen().map_err(|_| DataError::NoConvergence { what })?;
        let (s, u) = (eigen.S(), eigen.U());
        let values = (0..n).rev().map(|i| s[i].max(0.0)).collect();
        let vectors = Mat::from_fn(n, n, |i, j| u[(i, n - 1 - j)]);
        Ok(Self { values, vectors })
    }

    /// How many eigenvalues are above the rounding of the largest.
    pub(crate) fn rank(&self) -> usize {
        // Rounding of a covariance is `n ε` of its largest entry; a hundred times that is safe.
        let largest = self.values.first().copied().unwrap_or(0.0);
        let least = 100.0 * self.values.len() as f64 * f64::EPSILON * largest;
        self.values.iter().take_while(|&&value| value > least).count()
    }
}
