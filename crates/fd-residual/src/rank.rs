//! Deciding ranks, and saying how near the decision was.
//!
//! A matrix that was computed from a model has the rank that its numbers say, and another rank a little
//! beside them. Signatures, null spaces, parity vectors, banks and observers of unknown inputs decide in
//! natural units ([`StateSpace::natural_units`](fd_model::StateSpace::natural_units)), by singular values, and
//! relative to what a change of the *whole* data can do to the matrix in question: a tolerance of `1e-10` says
//! that `A`, `B`, `C` and `D` are known to ten digits, and that what a change in the eleventh could have
//! made is not told from zero. The matrix's own size is no measure, because it may be nothing but rounding.

use std::fmt;

use faer::{Mat, MatRef};
use fd_model::ModelError;
use fd_numeric::dense::{Dense, Svd};

use crate::error::DesignError;

/// How well the entries of a model are known, relative to the size of its matrices in natural units.
///
/// # Examples
///
/// ```
/// use fd_residual::rank::RankTolerance;
///
/// let identified = RankTolerance::new(1e-4)?; // a model from logs has four digits at best
/// assert!(RankTolerance::default().value() < identified.value());
/// assert!(RankTolerance::new(0.0).is_err());
/// # Ok::<(), fd_residual::DesignError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct RankTolerance(f64);

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

    /// The number.
    #[must_use]
    pub fn value(self) -> f64 {
        self.0
    }
}

/// Ten digits: a model in `f64` after a few changes of coordinates.
impl Default for RankTolerance {
    fn default() -> Self {
        Self(1e-10)
    }
}

/// How a rank was decided. All values are relative to what a relative change of the data of size one
/// could do.
///
/// # Examples
///
/// ```
/// use fd_residual::rank::{RankDecision, RankTolerance};
///
/// let near = RankDecision::of(4, &[1.0, 0.5, 1e-3, 2.5e-12], RankTolerance::default());
/// assert_eq!(near.rank, 3);
/// assert!((near.margin() - 40.0).abs() < 1e-12);
/// let told = near.to_string();
/// assert!(told.starts_with("rank 3 of 4; the next value is 40 times smaller than the tolerance"), "{told}");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RankDecision {
    /// Number of singular values above the tolerance.
    pub rank: usize,
    /// Rows of the matrix.
    pub rows: usize,
    /// Smallest singular value that counts; zero when none does.
    pub smallest_kept: f64,
    /// Largest singular value that counts as zero; zero when there is none.
    pub largest_dropped: f64,
    /// Border between the two.
    pub tolerance: f64,
}

impl RankDecision {
    /// The decision about relative singular values, largest first, of a matrix with `rows` rows.
    #[must_use]
    pub fn of(rows: usize, values: &[f64], tolerance: RankTolerance) -> Self {
        let tolerance = tolerance.value();
        let rank = values.iter().take_while(|&&value| tolerance < value).count();
        let smallest_kept = if rank == 0 { 0.0 } else { values[rank - 1] };
        let largest_dropped = values.get(rank).copied().unwrap_or(0.0);
        Self { rank, rows, smallest_kept, largest_dropped, tolerance }
    }

    /// Factor between the tolerance and the value nearest to it: with a tolerance that much larger or
    /// smaller, the rank would be another one. Infinite when there is no such value.
    #[must_use]
    pub fn margin(&self) -> f64 {
        let above =
            if self.rank == 0 { f64::INFINITY } else { self.smallest_kept / self.tolerance };
        let below = if 0.0 < self.largest_dropped {
            self.tolerance / self.largest_dropped
        } else {
            f64::INFINITY
        };
        above.min(below)
    }

    /// The one with the smaller margin.
    #[must_use]
    pub fn nearer(self, other: Self) -> Self {
        if other.margin() < self.margin() { other } else { self }
    }

    /// Nothing to decide.
    pub(crate) fn clear(tolerance: RankTolerance) -> Self {
        Self::of(0, &[], tolerance)
    }
}

impl fmt::Display for RankDecision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { rank, rows, smallest_kept, largest_dropped, tolerance } = self;
        write!(f, "rank {rank} of {rows}; ")?;
        if 0.0 < *largest_dropped {
            let ratio = Times(tolerance / largest_dropped);
            write!(
                f,
                "the next value is {ratio} times smaller than the tolerance {tolerance:.0e}"
            )?;
        } else {
            write!(f, "there is no further value")?;
        }
        if 0 < *rank {
            write!(f, ", the last one {} times larger", Times(smallest_kept / tolerance))?;
        }
        Ok(())
    }
}

/// A factor in two digits.
struct Times(f64);

impl fmt::Display for Times {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 < 9.95 {
            write!(f, "{:.1}", self.0)
        } else if self.0 < 1e3 {
            write!(f, "{:.0}", self.0)
        } else {
            write!(f, "{:.0e}", self.0)
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
