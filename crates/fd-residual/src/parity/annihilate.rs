//! Left null spaces with their rank decision on the table.

use faer::{Mat, MatRef};
use fd_model::ModelError;

use crate::error::DesignError;

/// How the rank of a matrix was decided. All singular values are relative to the largest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RankDecision {
    /// Number of singular values above the tolerance.
    pub rank: usize,
    /// Rows of the matrix.
    pub rows: usize,
    /// Smallest singular value that counts.
    pub smallest_kept: f64,
    /// Largest singular value that counts as zero. The decision is clear when this is many orders
    /// of magnitude below `smallest_kept`.
    pub largest_dropped: f64,
    /// Border between the two.
    pub tolerance: f64,
}

/// Orthonormal rows that annihilate `m` from the left.
pub(crate) fn annihilators(
    m: MatRef<'_, f64>,
    tolerance: f64,
) -> Result<(Mat<f64>, RankDecision), DesignError> {
    let rows = m.nrows();
    if m.ncols() == 0 || m.norm_max() < f64::MIN_POSITIVE {
        let decision =
            RankDecision { rank: 0, rows, smallest_kept: 0.0, largest_dropped: 0.0, tolerance };
        return Ok((Mat::identity(rows, rows), decision));
    }
    let svd =
        m.svd().map_err(|_| ModelError::NoConvergence { what: "left null space", order: rows })?;
    let relative = |s: f64| s / svd.S()[0];
    let sigma: Vec<f64> = svd.S().column_vector().iter().map(|&s| relative(s)).collect();
    let rank = sigma.iter().filter(|&&s| tolerance < s).count();
    let decision = RankDecision {
        rank,
        rows,
        smallest_kept: sigma[rank - 1],
        largest_dropped: sigma.get(rank).copied().unwrap_or(0.0),
        tolerance,
    };
    Ok((svd.U().subcols(rank, rows - rank).transpose().to_owned(), decision))
}
