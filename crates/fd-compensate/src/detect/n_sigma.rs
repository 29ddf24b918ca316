//! The largest standardised residual.

use fd_core::{
    Scalar, StateVisitor,
    stage::{Detector, Stage, Verdict},
};

use super::{
    error::{DetectorError, positive},
    standardize::Standardizer,
};

/// Statistic `max_i |r_i − m_i| / σ_i`, threshold in standard deviations.
///
/// For white Gaussian residuals of one channel, 3 standard deviations give one false alarm in 370
/// samples.
#[derive(Clone, Debug, PartialEq)]
pub struct NSigma<T> {
    standardizer: Standardizer<T>,
    threshold: T,
}

impl<T: Scalar> NSigma<T> {
    /// The statistic with a threshold in standard deviations.
    ///
    /// ```
    /// use fd_compensate::detect::{NSigma, Standardizer};
    /// use fd_core::stage::Detector;
    ///
    /// let mut detector = NSigma::new(Standardizer::new(&[0.0], &[0.1])?, 3.0)?;
    /// assert!(detector.update(&[], &[-0.4]).alarm());
    /// # Ok::<(), fd_compensate::detect::DetectorError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when the threshold is not positive and finite.
    pub fn new(standardizer: Standardizer<T>, threshold: f64) -> Result<Self, DetectorError> {
        positive("threshold", threshold)?;
        Ok(Self { standardizer, threshold: T::from_design(threshold) })
    }

    /// The same statistic with another threshold.
    ///
    /// # Errors
    ///
    /// Returns an error when the threshold is not positive and finite.
    pub fn with_threshold(self, threshold: f64) -> Result<Self, DetectorError> {
        Self::new(self.standardizer, threshold)
    }
}

impl<T: Scalar> Stage<T> for NSigma<T> {
    fn reset(&mut self) {}

    fn visit_state(&mut self, _visitor: &mut dyn StateVisitor<T>) {}
}

impl<T: Scalar> Detector<T> for NSigma<T> {
    fn residual_len(&self) -> usize {
        self.standardizer.channels()
    }

    fn update(&mut self, _u: &[T], r: &[T]) -> Verdict<T> {
        let values = self.standardizer.values(r);
        let statistic = values.fold(T::zero(), |largest, z| largest.max(z.abs()));
        Verdict { statistic, threshold: self.threshold }
    }
}
