//! Generalised eigenvalues.

use faer::{
    Auto, Mat, MatRef, Par, Spec, c64,
    diag::Diag,
    dyn_stack::{MemBuffer, MemStack},
    linalg::{
        evd::ComputeEigenvectors,
        gevd::{GevdParams, gevd_real, gevd_scratch},
    },
};

use crate::error::ModelError;

/// The finite `λ` for which `A − λB` is singular, by the QZ algorithm.
///
/// faer 0.24's blocked QZ code loses accuracy and takes seconds for 75 ≤ n < 150, so the
/// unblocked code is asked for at every size.
pub(crate) fn finite_eigenvalues(
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
) -> Result<Vec<c64>, ModelError> {
    let n = a.nrows();
    if n == 0 {
        return Ok(Vec::new());
    }
    let mut config = <GevdParams as Auto<f64>>::auto();
    config.schur.blocking_threshold = usize::MAX;
    let params = Spec::<GevdParams, f64>::from(config);
    let (without, par) = (ComputeEigenvectors::No, Par::Seq);
    let mut memory = MemBuffer::new(gevd_scratch::<f64>(n, without, without, par, params));

    let (mut a_work, mut b_work) = (a.to_owned(), b.to_owned());
    let mut re = Diag::<f64>::zeros(n);
    let mut im = Diag::<f64>::zeros(n);
    let mut beta = Diag::<f64>::zeros(n);
    gevd_real(
        a_work.as_mut(),
        b_work.as_mut(),
        re.as_mut(),
        im.as_mut(),
        beta.as_mut(),
        None,
        None,
        par,
        MemStack::new(&mut memory),
        params,
    )
    .map_err(|_| ModelError::NoConvergence { what: "generalised eigenvalues", order: n })?;

    let (re, im, beta) = (re.column_vector(), im.column_vector(), beta.column_vector());
    let infinite = n as f64 * f64::EPSILON * b.norm_l2();
    Ok((0..n)
        .filter(|&i| infinite < beta[i].abs())
        .map(|i| c64::new(re[i] / beta[i], im[i] / beta[i]))
        .collect())
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
    let svd = a.svd().map_err(|_| ModelError::NoConvergence {
        what: "singular values",
        order: rows.min(cols),
    })?;
    let rank = svd.S().column_vector().iter().filter(|&&value| tolerance < value).count();
    Ok((svd.U().to_owned(), rank))
}
