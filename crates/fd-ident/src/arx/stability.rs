//! Poles of difference equations, and how to bring unstable ones inside the unit circle.

use faer::{Mat, c64};
use fd_numeric::dense::DenseReal;

use crate::{arx::ArxModel, error::IdentError};

/// Where an unstable pole goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// To its mirror image `1/p̄`; the inputs are rescaled so that the magnitude of the frequency
    /// response stays the same at every frequency.
    Reflect,
    /// Straight towards the origin, to the radius asked for; the numerator stays.
    Shrink,
}

/// A pole that was moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovedPole {
    /// Residual channel.
    pub channel: usize,
    /// Pole of the model as it was, per sample.
    pub from: c64,
    /// Pole of the projected model.
    pub to: c64,
}

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

    /// The model with every pole on or outside the unit circle moved to a radius of at most
    /// `largest_radius`, and the list of moved poles. Channels without such poles stay the same
    /// to the bit.
    ///
    /// A projected model can be simulated, but it no longer is the best fit: compare its
    /// simulation with the data before trusting it.
    ///
    /// # Errors
    ///
    /// Returns an error unless `0 < largest_radius < 1`, or as [`ArxModel::poles`].
    pub fn projected(
        &self,
        projection: Projection,
        largest_radius: f64,
    ) -> Result<(Self, Vec<MovedPole>), IdentError> {
        if !(0.0 < largest_radius && largest_radius < 1.0) {
            let (setting, expected) = ("largest pole radius", "between 0 and 1");
            return Err(IdentError::Setting { setting, expected, found: largest_radius });
        }
        let mut model = self.clone();
        let mut moved = Vec::new();
        for channel in 0..self.residual_len() {
            let mut poles = self.poles(channel)?;
            let before = moved.len();
            let mut gain = 1.0;
            for pole in poles.iter_mut().filter(|pole| pole.norm() >= 1.0) {
                let (from, radius) = (*pole, pole.norm());
                let target = match projection {
                    Projection::Reflect => {
                        // |1 − p e^{−jω}| = |p| |1 − e^{−jω}/p̄|.
                        gain /= radius;
                        largest_radius.min(1.0 / radius)
                    }
                    Projection::Shrink => largest_radius,
                };
                *pole = from * (target / radius);
                moved.push(MovedPole { channel, from, to: *pole });
            }
            if moved.len() > before {
                let (a, rest) = model.channel_mut(channel).split_at_mut(self.orders().na);
                a.copy_from_slice(&polynomial(&poles));
                for b in rest {
                    *b *= gain;
                }
            }
        }
        Ok((model, moved))
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
        .modes()
        .map_err(|_| IdentError::NoConvergence { what: "eigenvalues of the companion matrix" })
}

/// `a₁ … a_n` of the monic polynomial with these roots, which come in conjugate pairs.
fn polynomial(roots: &[c64]) -> Vec<f64> {
    let mut coefficients = vec![c64::new(1.0, 0.0)];
    for &root in roots {
        coefficients.push(c64::new(0.0, 0.0));
        for i in (1..coefficients.len()).rev() {
            let previous = coefficients[i - 1];
            coefficients[i] -= root * previous;
        }
    }
    coefficients[1..].iter().map(|c| c.re).collect()
}

/// Largest radius to which [`reflect`] moves a root; nearer to the circle a filter would not forget
/// its start within any record.
const LARGEST_REFLECTED: f64 = 0.9999;

/// Reflects the roots of a monic polynomial into the unit circle, and returns by how much a
/// numerator over it has to be multiplied to keep its magnitude at all frequencies.
pub(crate) fn reflect(a: &mut [f64]) -> Result<f64, IdentError> {
    let mut roots = roots(a)?;
    let (mut gain, mut moved) = (1.0, false);
    for root in roots.iter_mut().filter(|root| root.norm() >= 1.0) {
        let radius = root.norm();
        gain /= radius;
        moved = true;
        *root *= LARGEST_REFLECTED.min(1.0 / radius) / radius;
    }
    if moved {
        a.copy_from_slice(&polynomial(&roots));
    }
    Ok(gain)
}
