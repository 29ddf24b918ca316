//! Poles of difference equations, and how to bring unstable ones inside the unit circle.

use faer::{Mat, c64};

use crate::{arx::ArxModel, error::IdentError};

impl ArxModel {
    /// Poles of one residual channel, per sample: the roots of `z^na + a₁ z^(na−1) + … + a_na`.
    ///
    /// # Errors
    ///
    /// Returns an error when the eigenvalues of the companion matrix do not converge.
    pub fn poles(&self, channel: usize) -> Result<Vec<c64>, IdentError> {
        roots(self.a(channel))
    }

    /// Whether all poles of all channels lie inside the unit circle.
    ///
    /// # Errors
    ///
    /// As [`ArxModel::poles`].
    pub fn is_stable(&self) -> Result<bool, IdentError> {
        for channel in 0..self.residual_len() {
            if self.poles(channel)?.iter().any(|pole| pole.norm() >= 1.0) {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

/// Roots of the monic polynomial `z^n + a₁ z^(n−1) + … + a_n`.
pub(crate) fn roots(a: &[f64]) -> Result<Vec<c64>, IdentError> {
    let n = a.len();
    if n == 0 {
        return Ok(Vec::new());
    }
    let companion = Mat::from_fn(n, n, |i, j| match i {
        0 => -a[j],
        _ => f64::from(u8::from(i == j + 1)),
    });
    companion
        .eigenvalues()
        .map_err(|_| IdentError::NoConvergence { what: "eigenvalues of the companion matrix" })
}
