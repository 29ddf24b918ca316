//! The residual against its bound, sample by sample.

use fd_core::{
    HeapMap, LinMap, Scalar, StateVisitor,
    stage::{Detector, Stage, Verdict},
};

use super::{InputBound, bank::InputNorms, learn::Evaluation};
use crate::detect::error::{DetectorError, positive};

/// The largest ratio of a residual channel to its bound `J_i(k)`, see the [module](super).
///
/// The threshold is the factor by which all bounds are widened; 1 takes them as they are.
#[derive(Clone, Debug)]
pub struct AdaptiveThreshold<T: Scalar> {
    norms: InputNorms<T>,
    noise: Vec<T>,
    gains: HeapMap<T>,
    evaluation: Evaluation,
    factor: T,
    /// Mean square of each channel over the window.
    power: Vec<T>,
    bounds: Vec<T>,
    /// Norms beyond which nothing is known, and those below which something is again.
    left: Vec<T>,
    regained: Vec<T>,
    is_void: bool,
}

impl<T: Scalar> AdaptiveThreshold<T> {
    /// Compares the magnitude of each sample: the adaptive threshold.
    ///
    /// ```
    /// use fd_compensate::detect::{AdaptiveThreshold, adaptive::{Bands, InputBound}};
    /// use fd_core::stage::Detector;
    ///
    /// // |r| <= 0.1 + 0.2 ‖u‖, one band.
    /// let bound = InputBound::new(Bands::new(&[], 10.0)?, 1, &[0.1], &[0.2])?;
    /// let mut detector = AdaptiveThreshold::of_magnitude(&bound, 1.0)?;
    /// assert!(!detector.update(&[1.0], &[0.25]).alarm());
    /// assert!(detector.update(&[1.0], &[-0.35]).alarm());
    /// assert!((detector.thresholds().next().unwrap_or(0.0_f64) - 0.3).abs() < 1e-15);
    /// # Ok::<(), fd_compensate::detect::DetectorError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when the factor is not positive and finite.
    pub fn of_magnitude(bound: &InputBound, factor: f64) -> Result<Self, DetectorError> {
        Self::new(bound, Evaluation::Magnitude, factor)
    }

    /// Compares the root mean square over the window of the norms: the threshold selector.
    ///
    /// The window of the residual begins empty, so that the first samples count less.
    ///
    /// # Errors
    ///
    /// Returns an error when the factor is not positive and finite.
    pub fn of_rms(bound: &InputBound, factor: f64) -> Result<Self, DetectorError> {
        Self::new(bound, Evaluation::RootMeanSquare, factor)
    }

    /// Compares what `evaluation` says.
    ///
    /// # Errors
    ///
    /// Returns an error when the factor is not positive and finite.
    pub fn new(
        bound: &InputBound,
        evaluation: Evaluation,
        factor: f64,
    ) -> Result<Self, DetectorError> {
        positive("threshold", factor)?;
        let (channels, nu, count) = (bound.residual_len(), bound.nu(), bound.bands().count());
        let (largest, margin) = bound.largest_norms();
        let limits = |share: f64| -> Vec<T> {
            largest.iter().map(|norm| T::from_design(norm * (1.0 + share * margin))).collect()
        };
        Ok(Self {
            norms: InputNorms::new(bound.bands(), nu),
            noise: bound.noise().iter().map(|&a| T::from_design(a)).collect(),
            gains: HeapMap::from_fn(channels, nu * count, |i, at| {
                T::from_design(bound.weights(i, at / count)[at % count])
            }),
            evaluation,
            factor: T::from_design(factor),
            power: vec![T::zero(); channels],
            bounds: vec![T::zero(); channels],
            left: limits(1.0),
            regained: limits(0.5),
            is_void: false,
        })
    }

    /// The same bounds with another factor.
    ///
    /// # Errors
    ///
    /// Returns an error when the factor is not positive and finite.
    pub fn with_threshold(mut self, factor: f64) -> Result<Self, DetectorError> {
        positive("threshold", factor)?;
        self.factor = T::from_design(factor);
        Ok(self)
    }

    /// `J_th` of each channel at the last sample, in the unit of the residual.
    pub fn thresholds(&self) -> impl Iterator<Item = T> {
        self.bounds.iter().map(|&bound| self.factor * bound)
    }
}

impl<T: Scalar> Stage<T> for AdaptiveThreshold<T> {
    fn reset(&mut self) {
        self.norms.reset();
        self.power.fill(T::zero());
        self.bounds.fill(T::zero());
        self.is_void = false;
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        self.norms.visit_state(visitor);
        visitor.reals("residual powers", &mut self.power);
        let mut void = [u64::from(self.is_void)];
        visitor.counts("threshold void", &mut void);
        self.is_void = void[0] != 0;
    }
}

impl<T: Scalar> Detector<T> for AdaptiveThreshold<T> {
    fn nu(&self) -> Option<usize> {
        Some(self.norms.nu())
    }

    fn residual_len(&self) -> usize {
        self.noise.len()
    }

    fn update(&mut self, u: &[T], r: &[T]) -> Verdict<T> {
        let forget = self.norms.forget();
        self.bounds.copy_from_slice(&self.noise);
        let norms = self.norms.update(u);
        let limits = if self.is_void { &self.regained } else { &self.left };
        self.is_void = norms.iter().zip(limits).any(|(norm, limit)| limit < norm);
        self.gains.mul_add_into(norms, &mut self.bounds);
        let mut statistic = T::zero();
        for ((&r, power), &bound) in r.iter().zip(&mut self.power).zip(&self.bounds) {
            *power += forget * (r * r - *power);
            let value = match self.evaluation {
                Evaluation::Magnitude => r.abs(),
                Evaluation::RootMeanSquare => power.sqrt(),
            };
            statistic = statistic.max(value / bound);
        }
        Verdict { statistic, threshold: self.factor }
    }

    fn is_void(&self) -> bool {
        self.is_void
    }
}
