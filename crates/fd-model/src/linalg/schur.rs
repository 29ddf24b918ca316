//! Real Schur form, from nalgebra because faer keeps its own private.

use faer::{Mat, MatRef};
use nalgebra::DMatrix;

use crate::error::ModelError;

/// `A = Q T Qᵀ` with `Q` orthogonal and `T` upper triangular but for 2×2 blocks on its diagonal.
pub(crate) struct RealSchur {
    pub q: Mat<f64>,
    pub t: Mat<f64>,
}

impl RealSchur {
    /// Decomposes a square matrix.
    pub(crate) fn new(a: MatRef<'_, f64>) -> Result<Self, ModelError> {
        // LAPACK's `hseqr` allows 30 iterations per eigenvalue.
        const ITERATIONS_PER_EIGENVALUE: usize = 30;

        let n = a.nrows();
        let copy = DMatrix::from_fn(n, n, |i, j| a[(i, j)]);
        let iterations = ITERATIONS_PER_EIGENVALUE * n.max(10);
        let (q, t) = nalgebra::linalg::Schur::try_new(copy, f64::EPSILON, iterations)
            .ok_or(ModelError::NoConvergence { what: "the Schur form", order: n })?
            .unpack();
        let quasi_triangular = |i: usize, j: usize| if i <= j + 1 { t[(i, j)] } else { 0.0 };
        Ok(Self {
            q: Mat::from_fn(n, n, |i, j| q[(i, j)]),
            t: Mat::from_fn(n, n, quasi_triangular),
        })
    }

    /// Starts and sizes (one or two) of the diagonal blocks.
    pub(crate) fn blocks(&self) -> Vec<(usize, usize)> {
        let n = self.t.nrows();
        let mut blocks = Vec::new();
        let mut start = 0;
        while start < n {
            let pair = start + 1 < n && self.t[(start + 1, start)].abs() > 0.0;
            let size = if pair { 2 } else { 1 };
            blocks.push((start, size));
            start += size;
        }
        blocks
    }
}
