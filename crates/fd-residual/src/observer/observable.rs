//! Whether the outputs show a mode.

use faer::{Mat, MatRef, c64};
use fd_numeric::dense::{Dense, DenseReal};

use crate::error::{DesignError, no_convergence};

/// A mode is unobservable when `[A − p I; C]` is closer than this to losing rank.
const UNOBSERVABLE: f64 = 1e-10;

/// Checks by the Popov-Belevitch-Hautus test that the outputs show each mode that `matters`.
pub(crate) fn check_observable(
    a: MatRef<'_, f64>,
    c: MatRef<'_, f64>,
    matters: impl Fn(c64) -> bool,
) -> Result<(), DesignError> {
    let n = a.nrows();
    if n == 0 {
        return Ok(());
    }
    let scale = a.norm_l2().hypot(c.norm_l2());
    let modes = a.modes().map_err(|_| no_convergence("eigenvalues", n))?;
    for mode in modes.into_iter().filter(|&mode| matters(mode)) {
        let pencil = Mat::from_fn(n + c.nrows(), n, |i, j| {
            if n <= i {
                return c64::new(c[(i - n, j)], 0.0);
            }
            let shift = if i == j { mode } else { c64::new(0.0, 0.0) };
            c64::new(a[(i, j)], 0.0) - shift
        });
        let sigma = pencil.sigmas().map_err(|_| no_convergence("singular values", n))?;
        let distance = sigma.last().copied().unwrap_or(0.0) / scale;
        // A zero matrix pair has scale zero and shows nothing.
        if distance.is_nan() || distance <= UNOBSERVABLE {
            return Err(DesignError::Unobservable { re: mode.re, im: mode.im, distance });
        }
    }
    Ok(())
}
