//! The running cumulative sum.

use fd_core::{
    Scalar, StateVisitor,
    stage::{Detector, Stage, Verdict},
};

use crate::detect::{
    error::{DetectorError, positive},
    standardize::Standardizer,
};

/// Two-sided cumulative sum of each channel; the statistic is the largest of all, see the
/// [module](super).
#[derive(Clone, Debug, PartialEq)]
pub struct Cusum<T> {
    standardizer: Standardizer<T>,
    reference: T,
    threshold: T,
    upper: Vec<T>,
    lower: Vec<T>,
}

impl<T: Scalar> Cusum<T> {
    /// The sum with reference value `k` and threshold `h`, both in standard deviations.
    ///
    /// ```
    /// use fd_compensate::detect::{Cusum, Standardizer};
    /// use fd_core::stage::Detector;
    ///
    /// let mut detector = Cusum::new(Standardizer::new(&[0.0], &[1.0])?, 0.5, 4.0)?;
    /// let alarms = (0..10).filter(|_| detector.update(&[], &[1.0]).alarm()).count();
    /// assert_eq!(alarms, 2); // 0.5 a sample: beyond 4 from the ninth on
    /// # Ok::<(), fd_compensate::detect::DetectorError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when `k` is negative or `h` is not positive.
    pub fn new(
        standardizer: Standardizer<T>,
        reference: f64,
        threshold: f64,
    ) -> Result<Self, DetectorError> {
        if reference < 0.0 || !reference.is_finite() {
            let (parameter, expected) = ("reference value k", "non-negative and finite");
            return Err(DetectorError::Parameter { parameter, expected, found: reference });
        }
        positive("threshold h", threshold)?;
        let zeros = vec![T::zero(); standardizer.channels()];
        Ok(Self {
            standardizer,
            reference: T::from_design(reference),
            threshold: T::from_design(threshold),
            upper: zeros.clone(),
            lower: zeros,
        })
    }

    /// The same statistic with another threshold.
    ///
    /// # Errors
    ///
    /// Returns an error when the threshold is not positive and finite.
    pub fn with_threshold(mut self, threshold: f64) -> Result<Self, DetectorError> {
        positive("threshold h", threshold)?;
        self.threshold = T::from_design(threshold);
        Ok(self)
    }
}

impl<T: Scalar> Stage<T> for Cusum<T> {
    fn reset(&mut self) {
        self.upper.fill(T::zero());
        self.lower.fill(T::zero());
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("cusum upper", &mut self.upper);
        visitor.reals("cusum lower", &mut self.lower);
    }
}

impl<T: Scalar> Detector<T> for Cusum<T> {
    fn residual_len(&self) -> usize {
        self.standardizer.channels()
    }

    fn update(&mut self, _u: &[T], r: &[T]) -> Verdict<T> {
        let mut statistic = T::zero();
        let sums = self.upper.iter_mut().zip(&mut self.lower);
        for (z, (upper, lower)) in self.standardizer.values(r).zip(sums) {
            *upper = (*upper + z - self.reference).max(T::zero());
            *lower = (*lower - z - self.reference).max(T::zero());
            statistic = statistic.max(*upper).max(*lower);
        }
        Verdict { statistic, threshold: self.threshold }
    }
}
