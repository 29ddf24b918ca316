//! Generalised eigenvalues and rank-revealing rotations.

use faer::{Mat, MatRef, Scale, c64, prelude::Solve};
use fd_numeric::dense::Dense;

use crate::{
    error::ModelError,
    linalg::{eigenvalues::eigenvalues, svd::svd},
};

/// The `λ` for which `A − λB` is singular, for an invertible `B`.
///
/// By ordinary eigenvalues `μ` of `(A − σB)⁻¹ B`, as `λ = σ + 1/μ`: backward stable when
/// `A − σB` is well-conditioned, for which the best of several `σ` is taken. faer 0.24's QZ is no
/// way round: it gives the second of a complex pair a wrong scale, and without eigenvectors
/// leaves out most eigenvalues for n ≥ 60.
///
/// # Errors
///
/// Returns an error when `A − λB` is singular for all shifts that were tried.
pub(crate) fn generalised_eigenvalues(
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
) -> Result<Vec<c64>, ModelError> {
    // Multiples of ‖A‖/‖B‖, on both sides of zero and of one in size.
    const SHIFTS: [f64; 6] = [-0.09, 0.13, -0.57, 0.71, -1.9, 2.3];

    let n = a.nrows();
    if n == 0 {
        return Ok(Vec::new());
    }
    let rate = a.norm_l2().max(f64::MIN_POSITIVE) / b.norm_l2();
    let (mut best, mut best_condition) = (None, n as f64 * f64::EPSILON);
    for shift in SHIFTS.map(|shift| shift * rate) {
        let shifted = a - Scale(shift) * b;
        let gains = svd(shifted.as_ref())?.values;
        let condition = gains[n - 1] / gains[0];
        if best_condition < condition {
            (best, best_condition) = (Some((shift, shifted)), condition);
        }
    }
    let (shift, shifted) = best.ok_or(ModelError::Singular { role: "the system pencil" })?;
    let inverse = eigenvalues(shifted.lu().solve(b).as_ref())?;
    Ok(inverse.into_iter().map(|mu| mu.inv() + shift).collect())
}

/// `Q` orthogonal with `Qᵀ A = [R; 0]`, and the number of rows of `R`: the singular values of
/// `A` above the tolerance.
pub(crate) fn compress_rows(
    a: MatRef<'_, f64>,
    tolerance: f64,
) -> Result<(Mat<f64>, usize), ModelError> {
    let (rows, cols) = (a.nrows(), a.ncols());
    if rows == 0 || cols == 0 {
        return Ok((Mat::identity(rows, rows), 0));
    }
    let svd = a.full_svd().map_err(|_| ModelError::NoConvergence {
        what: "singular values",
        order: rows.min(cols),
    })?;
    let rank = svd.S().column_vector().iter().filter(|&&value| tolerance < value).count();
    Ok((svd.U().to_owned(), rank))
}
