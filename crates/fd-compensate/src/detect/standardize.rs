//! Residuals in units of their own fault-free spread.

use fd_core::Scalar;
use fd_numeric::median;
use serde::{Deserialize, Serialize};

use super::error::{DetectorError, finite, length, positive};
use crate::rows::SampleRows;

/// How centre and spread of the fault-free residual are measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Spread {
    /// Mean and standard deviation.
    #[default]
    StandardDeviation,
    /// Median and median absolute deviation times 1.4826, which equals the standard deviation for
    /// Gaussian noise and is deaf to outliers.
    MedianAbsoluteDeviation,
}

/// `z_i = (r_i − m_i) / σ_i`.
#[derive(Clone, Debug, PartialEq)]
pub struct Standardizer<T> {
    centre: Vec<T>,
    inverse_spread: Vec<T>,
}

/// `1 / Φ⁻¹(3/4)`.
const MAD_TO_SIGMA: f64 = 1.482_602_218_505_602;

impl<T: Scalar> Standardizer<T> {
    /// From given centres `m` and spreads `σ`, one of each for each channel.
    ///
    /// ```
    /// use fd_compensate::detect::Standardizer;
    ///
    /// let z = Standardizer::<f64>::new(&[1.0], &[0.5])?;
    /// assert_eq!(z.values(&[2.0]).next(), Some(2.0));
    /// # Ok::<(), fd_compensate::detect::DetectorError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when the lists differ in length, a centre is not finite or a spread is not
    /// positive.
    pub fn new(centre: &[f64], spread: &[f64]) -> Result<Self, DetectorError> {
        length("spread", centre.len(), spread.len())?;
        centre.iter().try_for_each(|&m| finite("centre", m))?;
        spread.iter().try_for_each(|&s| positive("spread", s))?;
        Ok(Self {
            centre: centre.iter().map(|&m| T::from_design(m)).collect(),
            inverse_spread: spread.iter().map(|s| T::from_design(s.recip())).collect(),
        })
    }

    /// From fault-free residuals.
    ///
    /// # Errors
    ///
    /// Returns an error when a channel has no spread.
    pub fn from_fault_free(healthy: SampleRows<'_>, spread: Spread) -> Result<Self, DetectorError> {
        let (centres, spreads): (Vec<_>, Vec<_>) = (0..healthy.channels())
            .map(|channel| centre_and_spread(healthy.channel(channel).collect(), spread))
            .unzip();
        if let Some(channel) = spreads.iter().position(|&s| s <= 0.0) {
            return Err(DetectorError::ConstantChannel { channel, samples: healthy.len() });
        }
        Self::new(&centres, &spreads)
    }

    /// Number of channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.centre.len()
    }

    /// The standardised values of one sample.
    pub fn values(&self, r: &[T]) -> impl Iterator<Item = T> {
        let scales = self.centre.iter().zip(&self.inverse_spread);
        r.iter().zip(scales).map(|(&r, (&centre, &inverse))| (r - centre) * inverse)
    }
}

fn centre_and_spread(mut values: Vec<f64>, spread: Spread) -> (f64, f64) {
    match spread {
        Spread::StandardDeviation => {
            let n = values.len() as f64;
            let mean = values.iter().sum::<f64>() / n;
            let squares = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>();
            (mean, (squares / (n - 1.0).max(1.0)).sqrt())
        }
        Spread::MedianAbsoluteDeviation => {
            let centre = median(&mut values);
            for v in &mut values {
                *v = (*v - centre).abs();
            }
            (centre, MAD_TO_SIGMA * median(&mut values))
        }
    }
}
