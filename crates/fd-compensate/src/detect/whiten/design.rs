//! Coefficients of the whitening filter, and what becomes of a fault in it.

use faer::Mat;
use fd_numeric::dot;

use crate::{
    detect::{
        chi_square::{moments, whitening},
        error::{DetectorError, finite, length},
    },
    rows::SampleRows,
};

/// Mean, prediction coefficients and whitening matrix of a residual, see the [module](super).
#[derive(Clone, Debug, PartialEq)]
pub struct WhitenerDesign {
    pub(super) mean: Vec<f64>,
    /// `a_ci` of each channel, nearest sample first; all of one length.
    pub(super) coefficients: Vec<Vec<f64>>,
    pub(super) across: Mat<f64>,
}

impl WhitenerDesign {
    /// From given means, prediction coefficients of each channel, nearest sample first and all equally many,
    /// and the covariance of the prediction errors, row by row.
    ///
    /// # Errors
    ///
    /// Returns an error when sizes differ, a number is not finite or the covariance is not positive definite.
    pub fn new(
        mean: &[f64],
        coefficients: &[Vec<f64>],
        covariance: &[f64],
    ) -> Result<Self, DetectorError> {
        let n = mean.len();
        length("prediction coefficients", n, coefficients.len())?;
        length("covariance", n * n, covariance.len())?;
        let order = coefficients.first().map_or(0, Vec::len);
        for channel in coefficients {
            length("coefficients of a channel", order, channel.len())?;
            channel.iter().try_for_each(|&a| finite("coefficient", a))?;
        }
        mean.iter().try_for_each(|&m| finite("mean", m))?;
        covariance.iter().try_for_each(|&c| finite("covariance", c))?;
        let across = whitening(&Mat::from_fn(n, n, |i, j| covariance[i * n + j]), 0)?;
        Ok(Self { mean: mean.to_vec(), coefficients: coefficients.to_vec(), across })
    }

    /// From fault-free residuals, with at most `most_order` past samples; 0 whitens across channels only.
    ///
    /// ```
    /// use fd_compensate::{SampleRows, detect::whiten::WhitenerDesign};
    ///
    /// let healthy: Vec<f64> = (0..500).map(|k| (f64::from(k).powi(2) * 0.618).sin()).collect();
    /// let design = WhitenerDesign::from_fault_free(SampleRows::new(1, &healthy)?, 5)?;
    /// assert_eq!(design.channels(), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when a channel is constant, or a combination of the others.
    pub fn from_fault_free(
        healthy: SampleRows<'_>,
        most_order: usize,
    ) -> Result<Self, DetectorError> {
        let samples = healthy.len();
        let most_order = most_order.min(samples / 4);
        let (mean, covariance) = moments(healthy);
        // Refuses constant channels in a way that names them.
        whitening(&covariance, samples)?;
        let mut coefficients: Vec<Vec<f64>> = (0..healthy.channels())
            .map(|channel| {
                let z: Vec<f64> = healthy.channel(channel).map(|r| r - mean[channel]).collect();
                prediction(&z, most_order)
            })
            .collect();
        let order = coefficients.iter().map(Vec::len).max().unwrap_or(0);
        for channel in &mut coefficients {
            channel.resize(order, 0.0);
        }
        let errors: Vec<f64> = (0..samples)
            .flat_map(|k| {
                let (coefficients, mean) = (&coefficients, &mean);
                (0..healthy.channels()).map(move |c| {
                    let z = |k: usize| healthy.row(k)[c] - mean[c];
                    let past = coefficients[c].iter().zip((0..k).rev());
                    z(k) - past.map(|(a, k)| a * z(k)).sum::<f64>()
                })
            })
            .collect();
        let errors = SampleRows::new(healthy.channels(), &errors)
            .map_err(|_| DetectorError::SingularCovariance { channel: 0 })?;
        let across = whitening(&moments(errors).1, samples)?;
        Ok(Self { mean, coefficients, across })
    }

    /// Number of channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.mean.len()
    }

    /// Past samples that each prediction uses.
    #[must_use]
    pub fn order(&self) -> usize {
        self.coefficients.first().map_or(0, Vec::len)
    }

    /// What a fault with effect `gain · profile(k)` on the residual from `k = 0` on adds to the whitened
    /// residual, for as many samples as the profile has.
    ///
    /// # Errors
    ///
    /// Returns an error when there is not one gain for each channel.
    pub fn response(&self, gain: &[f64], profile: &[f64]) -> Result<Vec<Vec<f64>>, DetectorError> {
        length("gain", self.channels(), gain.len())?;
        let filtered = |c: usize, k: usize| {
            let past = self.coefficients[c].iter().zip(profile[..k].iter().rev());
            gain[c] * (profile[k] - past.map(|(a, s)| a * s).sum::<f64>())
        };
        let mixed = |row: usize, k: usize| {
            (0..self.channels()).map(|c| self.across[(row, c)] * filtered(c, k)).sum()
        };
        Ok((0..profile.len())
            .map(|k| (0..self.channels()).map(|row| mixed(row, k)).collect())
            .collect())
    }
}

/// Coefficients of the linear prediction of `z` with the order that Akaike's criterion prefers.
fn prediction(z: &[f64], most_order: usize) -> Vec<f64> {
    let n = z.len() as f64;
    let autocovariance: Vec<f64> = (0..=most_order).map(|lag| dot(z, &z[lag..]) / n).collect();
    // Levinson's recursion: the solution of each order from that of the order before.
    let (mut a, mut variance) = (Vec::new(), autocovariance[0]);
    let (mut best, mut least) = (a.clone(), n * variance.ln());
    for order in 1..=most_order {
        let known: f64 =
            a.iter().zip(autocovariance[1..order].iter().rev()).map(|(a, c)| a * c).sum();
        let reflection = (autocovariance[order] - known) / variance;
        let mirrored: Vec<f64> = a.iter().rev().map(|a| reflection * a).collect();
        for (a, m) in a.iter_mut().zip(mirrored) {
            *a -= m;
        }
        a.push(reflection);
        variance *= 1.0 - reflection * reflection;
        let criterion = n * variance.ln() + 2.0 * order as f64;
        if variance <= 0.0 || !criterion.is_finite() {
            break;
        }
        if criterion < least {
            (best, least) = (a.clone(), criterion);
        }
    }
    best
}
