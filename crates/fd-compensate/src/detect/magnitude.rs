//! The paper's detector: the largest magnitude next to that of the fault-free case.

use fd_core::{
    Scalar, StateVisitor,
    stage::{Detector, Stage, Verdict},
};
use serde::{Deserialize, Serialize};

use super::error::{DetectorError, positive};
use crate::rows::SampleRows;

/// "Slightly larger": the threshold exceeds the fault-free maximum by this share.
pub const DEFAULT_MARGIN: f64 = 0.05;

/// How the magnitudes of several channels become one number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Norm {
    /// The largest: a fault that shows in one channel.
    #[default]
    Max,
    /// The root of the sum of squares: a fault that shows in all channels.
    Euclidean,
    /// The sum.
    Sum,
}

/// A norm of `r_i / s_i`, by default `max_i |r_i| / s_i`, against one threshold.
///
/// Patton & Chen (1992), section 1: "the threshold is set slightly larger than the largest
/// magnitude of the residual evaluation function for the fault-free case". A scalar residual has
/// `s = 1`, so that statistic and threshold are in the unit of the residual; with several
/// channels `s_i` is the fault-free maximum of channel `i` and the threshold is `1 + margin`.
///
/// The rule states no false-alarm rate: the maximum grows with the length of the fault-free data. Use
/// [`Magnitude::with_threshold`] and a calibrated threshold where a rate is wanted.
#[derive(Clone, Debug, PartialEq)]
pub struct Magnitude<T> {
    inverse_scales: Vec<T>,
    norm: Norm,
    threshold: T,
}

impl<T: Scalar> Magnitude<T> {
    /// The statistic with given scales `s_i`, one for each channel, and a threshold.
    ///
    /// ```
    /// use fd_compensate::detect::Magnitude;
    /// use fd_core::stage::Detector;
    ///
    /// let mut detector = Magnitude::new(&[1.0, 10.0], 0.5)?;
    /// assert!(!detector.update(&[], &[0.4, -4.0]).alarm());
    /// assert!(detector.update(&[], &[0.4, -6.0]).alarm());
    /// # Ok::<(), fd_compensate::detect::DetectorError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when a scale or the threshold is not positive and finite.
    pub fn new(scales: &[f64], threshold: f64) -> Result<Self, DetectorError> {
        scales.iter().try_for_each(|&s| positive("scale", s))?;
        positive("threshold", threshold)?;
        let inverse_scales = scales.iter().map(|s| T::from_design(s.recip())).collect();
        Ok(Self { inverse_scales, norm: Norm::Max, threshold: T::from_design(threshold) })
    }

    /// The paper's rule: the threshold exceeds the fault-free maximum by the share `margin`, for
    /// which [`DEFAULT_MARGIN`] is a choice.
    ///
    /// ```
    /// use fd_compensate::{SampleRows, detect::{DEFAULT_MARGIN, Magnitude}};
    ///
    /// let healthy = [0.1, -0.4, 0.3];
    /// let healthy = SampleRows::new(1, &healthy)?;
    /// let detector = Magnitude::<f64>::above_fault_free_maximum(healthy, DEFAULT_MARGIN)?;
    /// assert!((detector.threshold() - 0.42).abs() < 1e-15);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when the margin is negative or a channel is zero throughout.
    pub fn above_fault_free_maximum(
        healthy: SampleRows<'_>,
        margin: f64,
    ) -> Result<Self, DetectorError> {
        if !(margin >= 0.0 && margin.is_finite()) {
            let (parameter, expected) = ("margin", "non-negative and finite");
            return Err(DetectorError::Parameter { parameter, expected, found: margin });
        }
        let maxima = healthy.per_channel(|v| v.fold(0.0, |peak: f64, v| peak.max(v.abs())));
        if let Some(channel) = maxima.iter().position(|&peak| peak <= 0.0) {
            return Err(DetectorError::ConstantChannel { channel, samples: healthy.len() });
        }
        match maxima[..] {
            [only] => Self::new(&[1.0], only * (1.0 + margin)),
            _ => Self::new(&maxima, 1.0 + margin),
        }
    }

    /// The paper's rule with a norm: the scales are the fault-free maxima of the channels, the threshold
    /// exceeds the fault-free maximum of the norm by the share `margin`.
    ///
    /// ```
    /// use fd_compensate::{SampleRows, detect::{Magnitude, Norm}};
    ///
    /// let healthy = [3.0, 0.0, 0.0, 4.0];
    /// let healthy = SampleRows::new(2, &healthy)?;
    /// let detector = Magnitude::<f64>::above_fault_free_norm(Norm::Euclidean, healthy, 0.0)?;
    /// assert_eq!(detector.threshold(), 1.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Magnitude::above_fault_free_maximum`].
    pub fn above_fault_free_norm(
        norm: Norm,
        healthy: SampleRows<'_>,
        margin: f64,
    ) -> Result<Self, DetectorError> {
        let mut design =
            Magnitude::<f64>::above_fault_free_maximum(healthy, margin)?.with_norm(norm);
        let peak = healthy.iter().map(|r| design.update(&[], r).statistic).fold(0.0, f64::max);
        let inverse_scales = design.inverse_scales.iter().map(|&s| T::from_design(s)).collect();
        let threshold = T::from_design(peak * (1.0 + margin));
        Ok(Self { inverse_scales, norm, threshold })
    }

    /// The same scales and threshold with another norm.
    #[must_use]
    pub fn with_norm(self, norm: Norm) -> Self {
        Self { norm, ..self }
    }

    /// The same statistic with another threshold.
    ///
    /// # Errors
    ///
    /// Returns an error when the threshold is not positive and finite.
    pub fn with_threshold(mut self, threshold: f64) -> Result<Self, DetectorError> {
        positive("threshold", threshold)?;
        self.threshold = T::from_design(threshold);
        Ok(self)
    }

    /// Largest statistic that counts as normal.
    #[must_use]
    pub fn threshold(&self) -> T {
        self.threshold
    }
}

impl<T: Scalar> Stage<T> for Magnitude<T> {
    fn reset(&mut self) {}

    fn visit_state(&mut self, _visitor: &mut dyn StateVisitor<T>) {}
}

impl<T: Scalar> Detector<T> for Magnitude<T> {
    fn residual_len(&self) -> usize {
        self.inverse_scales.len()
    }

    fn update(&mut self, _u: &[T], r: &[T]) -> Verdict<T> {
        let scaled = r.iter().zip(&self.inverse_scales).map(|(r, &s)| r.abs() * s);
        let statistic = match self.norm {
            Norm::Max => scaled.fold(T::zero(), T::max),
            Norm::Euclidean => scaled.fold(T::zero(), |sum, v| sum + v * v).sqrt(),
            Norm::Sum => scaled.fold(T::zero(), |sum, v| sum + v),
        };
        Verdict { statistic, threshold: self.threshold }
    }
}
