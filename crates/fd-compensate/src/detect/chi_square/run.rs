//! The running chi-square detector.

use fd_core::{
    HeapMap, LinMap, Scalar, Shape, StateVisitor,
    stage::{Detector, Stage, Verdict},
};

use super::design::{moments, whitening};
use crate::{
    detect::error::{DetectorError, finite, length, positive},
    rows::SampleRows,
};

/// Sum of `(r − m)ᵀ Σ⁻¹ (r − m)` over the last samples, see the [module](super).
///
/// Before the window has filled the sum is over what there is.
#[derive(Clone, Debug)]
pub struct ChiSquare<T: Scalar> {
    mean: Vec<T>,
    whitening: HeapMap<T>,
    threshold: T,
    /// Energies of the last samples, in a ring.
    window: Vec<T>,
    next: u64,
    centred: Vec<T>,
    white: Vec<T>,
}

impl<T: Scalar> ChiSquare<T> {
    /// From given mean and covariance, the latter row by row.
    ///
    /// ```
    /// use fd_compensate::detect::ChiSquare;
    /// use fd_core::stage::Detector;
    ///
    /// let mut detector = ChiSquare::new(&[0.0, 0.0], &[4.0, 0.0, 0.0, 1.0], 1, 13.8)?;
    /// assert_eq!(detector.update(&[], &[2.0, 3.0]).statistic, 10.0);
    /// # Ok::<(), fd_compensate::detect::DetectorError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when sizes differ, the covariance is not positive definite, or the window or
    /// the threshold is not positive.
    pub fn new(
        mean: &[f64],
        covariance: &[f64],
        window: usize,
        threshold: f64,
    ) -> Result<Self, DetectorError> {
        let n = mean.len();
        length("covariance", n * n, covariance.len())?;
        mean.iter().try_for_each(|&m| finite("mean", m))?;
        covariance.iter().try_for_each(|&c| finite("covariance", c))?;
        let covariance = faer::Mat::from_fn(n, n, |i, j| covariance[i * n + j]);
        Self::build(mean, &whitening(&covariance, 0)?, window, threshold)
    }

    /// From fault-free residuals.
    ///
    /// # Errors
    ///
    /// As [`ChiSquare::new`].
    pub fn from_fault_free(
        healthy: SampleRows<'_>,
        window: usize,
        threshold: f64,
    ) -> Result<Self, DetectorError> {
        let (mean, covariance) = moments(healthy);
        Self::build(&mean, &whitening(&covariance, healthy.len())?, window, threshold)
    }

    fn build(
        mean: &[f64],
        whitening: &faer::Mat<f64>,
        window: usize,
        threshold: f64,
    ) -> Result<Self, DetectorError> {
        let n = mean.len();
        positive("window", window as f64)?;
        positive("threshold", threshold)?;
        let shape = Shape::new(n, n);
        Ok(Self {
            mean: mean.iter().map(|&m| T::from_design(m)).collect(),
            whitening: HeapMap::from_fn(shape.rows, shape.cols, |i, j| {
                T::from_design(whitening[(i, j)])
            }),
            threshold: T::from_design(threshold),
            window: vec![T::zero(); window],
            next: 0,
            centred: vec![T::zero(); n],
            white: vec![T::zero(); n],
        })
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
}

impl<T: Scalar> Stage<T> for ChiSquare<T> {
    fn reset(&mut self) {
        self.window.fill(T::zero());
        self.next = 0;
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("chi-square window", &mut self.window);
        visitor.counts("chi-square next", std::slice::from_mut(&mut self.next));
    }
}

impl<T: Scalar> Detector<T> for ChiSquare<T> {
    fn residual_len(&self) -> usize {
        self.mean.len()
    }

    fn update(&mut self, _u: &[T], r: &[T]) -> Verdict<T> {
        for ((centred, &r), &mean) in self.centred.iter_mut().zip(r).zip(&self.mean) {
            *centred = r - mean;
        }
        self.whitening.mul_into(&self.centred, &mut self.white);
        let energy = self.white.iter().fold(T::zero(), |sum, &w| sum + w * w);
        let slots = self.window.len() as u64;
        // The remainder is below the length of a `Vec`, so it fits.
        let slot = usize::try_from(self.next % slots).unwrap_or(0);
        self.window[slot] = energy;
        self.next = (self.next + 1) % slots;
        // Summed afresh: a running sum would keep the rounding of every sample for ever.
        let statistic = self.window.iter().fold(T::zero(), |sum, &q| sum + q);
        Verdict { statistic, threshold: self.threshold }
    }
}
