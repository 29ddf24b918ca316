//! What a rank is decided by, and how near the decision was.

use std::fmt;

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
pub struct RankTolerance(pub(super) f64);

impl RankTolerance {
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
