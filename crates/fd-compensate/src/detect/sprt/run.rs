//! The running test.

use fd_core::{
    Scalar, StateVisitor,
    stage::{Detector, Stage, Verdict},
};
use serde::{Deserialize, Serialize};

use super::design::ErrorProbabilities;
use crate::detect::{
    error::{DetectorError, positive},
    standardize::Standardizer,
};

/// Which changes count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sides {
    /// Up and down: two tests for each channel.
    #[default]
    Both,
    /// Up only.
    Upper,
}

/// The restarted sequential test of each channel; the statistic is the largest log-likelihood ratio, see
/// the [module](super).
#[derive(Clone, Debug, PartialEq)]
pub struct Sprt<T> {
    standardizer: Standardizer<T>,
    delta: T,
    half: T,
    lower: T,
    threshold: T,
    sides: Sides,
    upward: Vec<T>,
    downward: Vec<T>,
}

impl<T: Scalar> Sprt<T> {
    /// The test for a mean of `delta` standard deviations, with Wald's boundaries.
    ///
    /// ```
    /// use fd_compensate::detect::{Sprt, Standardizer, sprt::{ErrorProbabilities, Sides}};
    /// use fd_core::stage::Detector;
    ///
    /// let errors = ErrorProbabilities { false_alarm: 0.01, missed: 0.05 };
    /// let z = Standardizer::new(&[0.0], &[1.0])?;
    /// let mut detector = Sprt::new(z, 1.0, errors, Sides::Both)?;
    /// let alarms = (0..10).filter(|_| detector.update(&[], &[1.0]).alarm()).count();
    /// assert_eq!(alarms, 1); // 0.5 a sample: beyond 4.55 with the tenth
    /// # Ok::<(), fd_compensate::detect::DetectorError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when `delta` or a probability is out of its range.
    pub fn new(
        standardizer: Standardizer<T>,
        delta: f64,
        errors: ErrorProbabilities,
        sides: Sides,
    ) -> Result<Self, DetectorError> {
        positive("shift to be found", delta)?;
        let (lower, upper) = errors.boundaries()?;
        let zeros = vec![T::zero(); standardizer.channels()];
        Ok(Self {
            standardizer,
            delta: T::from_design(delta),
            half: T::from_design(0.5 * delta),
            lower: T::from_design(lower),
            threshold: T::from_design(upper),
            sides,
            upward: zeros.clone(),
            downward: zeros,
        })
    }

    /// The same test with another upper boundary `ln B`.
    ///
    /// # Errors
    ///
    /// Returns an error when it is not positive and finite.
    pub fn with_threshold(mut self, threshold: f64) -> Result<Self, DetectorError> {
        positive("threshold ln B", threshold)?;
        self.threshold = T::from_design(threshold);
        Ok(self)
    }
}

impl<T: Scalar> Stage<T> for Sprt<T> {
    fn reset(&mut self) {
        self.upward.fill(T::zero());
        self.downward.fill(T::zero());
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("sprt upward", &mut self.upward);
        visitor.reals("sprt downward", &mut self.downward);
    }
}

impl<T: Scalar> Detector<T> for Sprt<T> {
    fn residual_len(&self) -> usize {
        self.standardizer.channels()
    }

    fn update(&mut self, _u: &[T], r: &[T]) -> Verdict<T> {
        let Self { delta, half, lower, .. } = *self;
        let test = |ratio: &mut T, z: T| {
            *ratio += delta * (z - half);
            if *ratio <= lower {
                *ratio = T::zero();
            }
            *ratio
        };
        // A test that has just begun says nothing yet.
        let mut statistic = lower;
        let tests = self.upward.iter_mut().zip(&mut self.downward);
        for (z, (upward, downward)) in self.standardizer.values(r).zip(tests) {
            statistic = statistic.max(test(upward, z));
            if self.sides == Sides::Both {
                statistic = statistic.max(test(downward, -z));
            }
        }
        Verdict { statistic, threshold: self.threshold }
    }
}
