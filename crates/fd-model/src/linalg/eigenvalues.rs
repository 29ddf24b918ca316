//! Eigenvalues of badly scaled matrices, and the check that they all decay.

use faer::{Mat, MatRef, c64};
use fd_numeric::dense::DenseReal;

use crate::{error::ModelError, linalg::balance::balance};

/// Eigenvalues, after balancing.
pub(crate) fn eigenvalues(a: MatRef<'_, f64>) -> Result<Vec<c64>, ModelError> {
    let n = a.nrows();
    if n == 0 {
        return Ok(Vec::new());
    }
    let scaling = balance(a, Mat::zeros(n, 0).as_ref(), Mat::zeros(0, n).as_ref());
    let failed = ModelError::NoConvergence { what: "eigenvalues", order: n };
    let values = scaling.a(a).modes().map_err(|_| failed.clone())?;
    if values.iter().all(|value| value.is_finite()) { Ok(values) } else { Err(failed) }
}

/// Checks that each of some eigenvalues has a positive margin of stability.
///
/// # Errors
///
/// Returns the worst of them when it does not.
pub(crate) fn require_decay(
    what: &'static str,
    eigenvalues: &[c64],
    margin: impl Fn(c64) -> f64,
) -> Result<(), ModelError> {
    match eigenvalues.iter().min_by(|p, q| margin(**p).total_cmp(&margin(**q))) {
        Some(worst) if margin(*worst) <= 0.0 => {
            Err(ModelError::Unstable { what, re: worst.re, im: worst.im })
        }
        _ => Ok(()),
    }
}
