//! Deciding ranks, and saying how near the decision was.
//!
//! A matrix that was computed from a model has the rank that its numbers say, and another rank a little
//! beside them. Signatures, null spaces, parity vectors, banks and observers of unknown inputs decide in
//! natural units ([`StateSpace::natural_units`](fd_model::StateSpace::natural_units)), by singular values, and
//! relative to what a change of the *whole* data can do to the matrix in question: a tolerance of `1e-10` says
//! that `A`, `B`, `C` and `D` are known to ten digits, and that what a change in the eleventh could have
//! made is not told from zero. The matrix's own size is no measure, because it may be nothing but rounding.

use faer::{Mat, MatRef};
use fd_model::ModelError;
use fd_numeric::dense::{Dense, Svd};

pub use self::decision::{RankDecision, RankTolerance};
use crate::error::DesignError;

mod decision;

impl RankTolerance {
    /// A relative tolerance.
    ///
    /// # Errors
    ///
    /// Returns an error unless it lies between rounding (`2.2e-16`) and one.
    pub fn new(tolerance: f64) -> Result<Self, DesignError> {
        if f64::EPSILON < tolerance && tolerance < 1.0 {
            Ok(Self(tolerance))
        } else {
            Err(DesignError::Tolerance { tolerance })
        }
    }
}

/// A matrix with its singular values, and its rank relative to `scale`.
pub(crate) struct Decided {
    pub decision: RankDecision,
    /// Absent for a matrix without rows or columns.
    pub svd: Option<Svd<f64>>,
    rows: usize,
    columns: usize,
}

/// Decides the rank of `m`, which a relative change of the data by `ε` moves by at most `ε scale`.
pub(crate) fn decide(
    m: MatRef<'_, f64>,
    scale: f64,
    tolerance: RankTolerance,
) -> Result<Decided, DesignError> {
    let (rows, columns) = (m.nrows(), m.ncols());
    if rows == 0 || columns == 0 {
        return Ok(Decided {
            decision: RankDecision::of(rows, &[], tolerance),
            svd: None,
            rows,
            columns,
        });
    }
    let failed = ModelError::NoConvergence { what: "rank", order: rows.min(columns) };
    let svd = m.full_svd().map_err(|_| failed)?;
    let scale = if 0.0 < scale { scale } else { 1.0 };
    let values: Vec<f64> = svd.S().column_vector().iter().map(|&s| s / scale).collect();
    Ok(Decided {
        decision: RankDecision::of(rows, &values, tolerance),
        svd: Some(svd),
        rows,
        columns,
    })
}

impl Decided {
    /// Orthonormal rows that annihilate the matrix from the left.
    pub(crate) fn annihilators(&self) -> Mat<f64> {
        let rank = self.decision.rank;
        self.svd.as_ref().map_or_else(
            || Mat::identity(self.rows, self.rows),
            |svd| svd.U().subcols(rank, self.rows - rank).transpose().to_owned(),
        )
    }

    /// Orthonormal rows with the span of those of the matrix.
    pub(crate) fn row_space(&self) -> Mat<f64> {
        let rank = self.decision.rank;
        self.svd.as_ref().map_or_else(
            || Mat::zeros(0, self.columns),
            |svd| svd.V().subcols(0, rank).transpose().to_owned(),
        )
    }

    /// Moore-Penrose inverse of the part that counts.
    pub(crate) fn pseudoinverse(&self) -> Mat<f64> {
        let Some(svd) = &self.svd else { return Mat::zeros(self.columns, self.rows) };
        let (rank, sigma) = (self.decision.rank, svd.S().column_vector());
        let scaled = Mat::from_fn(rank, self.rows, |i, j| svd.U()[(j, i)] / sigma[i]);
        svd.V().subcols(0, rank) * scaled
    }
}
