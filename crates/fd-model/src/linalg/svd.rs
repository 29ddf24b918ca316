//! Singular value decomposition with sizes of zero allowed.

use faer::{Mat, MatRef};
use fd_numeric::dense::Dense;

use crate::error::ModelError;

/// `A = U diag(values) Vᵀ` with as many columns in `U` and `V` as there are values.
pub(crate) struct Svd {
    pub u: Mat<f64>,
    /// Largest first.
    pub values: Vec<f64>,
    pub v: Mat<f64>,
}

/// Singular values, largest first: half the work of the decomposition.
pub(crate) fn singular_values(a: MatRef<'_, f64>) -> Result<Vec<f64>, ModelError> {
    if a.nrows() == 0 || a.ncols() == 0 {
        return Ok(Vec::new());
    }
    a.sigmas().map_err(|_| no_convergence(a))
}

/// Thin singular value decomposition.
pub(crate) fn svd(a: MatRef<'_, f64>) -> Result<Svd, ModelError> {
    if a.nrows() == 0 || a.ncols() == 0 {
        let (u, v) = (Mat::zeros(a.nrows(), 0), Mat::zeros(a.ncols(), 0));
        return Ok(Svd { u, values: Vec::new(), v });
    }
    let svd = a.economic_svd().map_err(|_| no_convergence(a))?;
    Ok(Svd {
        u: svd.U().to_owned(),
        values: svd.S().column_vector().iter().copied().collect(),
        v: svd.V().to_owned(),
    })
}

fn no_convergence(a: MatRef<'_, f64>) -> ModelError {
    ModelError::NoConvergence { what: "singular values", order: a.nrows().min(a.ncols()) }
}
