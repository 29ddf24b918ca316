//! From residuals to test statistics.

use crate::{scalar::Scalar, stage::Stage};

/// A change detector on a compensated residual.
///
/// A detector turns the residual vector of each sample into one number, the test statistic, and pairs it with
/// the largest value that counts as normal. It answers "how far from normal?". What to do about it (wait for a
/// second exceedance, name the fault, raise an alarm) is the [`DecisionRule`](super::DecisionRule)'s.
///
/// # The contract
///
/// * [`update`](Self::update) is called once per sample, in the order of time, with the input and the residual
///   of the same sample, and returns a [`Verdict`]. The input is provided for detectors whose threshold depends
///   on it; most ignore it.
/// * The statistic grows with the deviation, and an alarm is `statistic > threshold`. A two-sided test combines
///   its sides into one number.
/// * *The statistic must not depend on the threshold.* Calibration runs the detector over healthy data, reads
///   the statistics, and puts the threshold where it keeps the wanted rate of false alarms. A detector that
///   restarts after its own alarms would change its statistics while being calibrated.
/// * The statistic does not depend on the units or the order of the residual channels. Detectors achieve this
///   by scaling each channel with its healthy spread when they are built.
///
/// # Who calls it, and when
///
/// [`Pipeline::step`](crate::Pipeline::step), in *every* phase: while the compensator trains, what arrives is
/// an innovation. The decision rule mutes those verdicts, not the detector. A detector with memory therefore
/// enters the compensating phase with a few innovations in its window. This is harmless, since both are small
/// while the plant is healthy, and detectors need not know about phases.
///
/// Calibration, evaluation and Monte Carlo studies call it alone, thousands of times. `update` is their inner
/// loop.
///
/// # What an implementor must do
///
/// * *Check arguments in the constructor*: thresholds that are not positive, channels that never moved, a
///   covariance without an inverse. Return a typed error that names the channel.
/// * *Offer `from_fault_free(healthy, …)` and `with_threshold(…)`*, if the method allows it. Then a detector is
///   calibrated like all others.
/// * *Expose all memory*: windows with their position, sums and counters, all shown by
///   [`visit_state`](super::Stage::visit_state). The threshold is a constant and is not shown.
/// * *Neither allocate nor fail* in `update`. The length of a window is fixed at construction.
///
/// A NaN residual makes most statistics NaN, and `NaN > threshold` is not an alarm. Residuals are NaN only when
/// a nonlinear model has left its region of validity; check for that where such a model is used. The pipeline
/// resets the detector after such a sample.
///
/// # How it composes
///
/// As a type in [`Stages`](crate::Stages), as `Box<dyn Detector>`, or as `detector = { kind = … }` in a spec.
/// Add it to the list of `fd_compensate::testing`, and all shared tests of detectors cover yours.
///
/// # When not to implement it
///
/// For another norm or another threshold of an existing test: those are settings. For several tests at once:
/// run several pipelines on the same residuals, or combine the statistics in one detector, but do not vote
/// inside it. Voting is a decision.
///
/// # Example
///
/// The exponentially weighted moving average (Roberts 1959): `z ← z + λ (r/σ − z)`, whose standard deviation on
/// white noise tends to `√(λ / (2 − λ))`:
///
/// ```
/// use fd_core::{StateVisitor, stage::{Detector, Stage, Verdict}};
///
/// #[derive(Debug)]
/// struct Ewma {
///     /// Standard deviations of the healthy channels.
///     sigma: Vec<f64>,
///     lambda: f64,
///     threshold: f64,
///     averages: Vec<f64>,
/// }
///
/// impl Ewma {
///     fn new(sigma: &[f64], lambda: f64, sigmas: f64) -> Option<Self> {
///         let is_good = sigma.iter().all(|s| *s > 0.0) && 0.0 < lambda && lambda <= 1.0;
///         is_good.then(|| Self {
///             sigma: sigma.to_vec(),
///             lambda,
///             threshold: sigmas * (lambda / (2.0 - lambda)).sqrt(),
///             averages: vec![0.0; sigma.len()],
///         })
///     }
/// }
///
/// impl Stage for Ewma {
///     fn reset(&mut self) {
///         self.averages.fill(0.0);
///     }
///
///     fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
///         visitor.reals("moving averages", &mut self.averages);
///     }
/// }
///
/// impl Detector for Ewma {
///     fn residual_len(&self) -> usize {
///         self.sigma.len()
///     }
///
///     fn update(&mut self, _u: &[f64], r: &[f64]) -> Verdict<f64> {
///         let mut statistic = 0.0_f64;
///         for ((z, r), sigma) in self.averages.iter_mut().zip(r).zip(&self.sigma) {
///             *z += self.lambda * (r / sigma - *z);
///             statistic = statistic.max(z.abs());
///         }
///         Verdict { statistic, threshold: self.threshold }
///     }
/// }
///
/// assert!(Ewma::new(&[1.0, 0.0], 0.1, 3.0).is_none(), "a channel that never moved");
/// let Some(mut ewma) = Ewma::new(&[1.0, 0.2], 0.1, 3.0) else { return };
///
/// // A shift of one standard deviation would be lost in the noise of a single sample. The average
/// // passes 3 √(0.1 / 1.9) = 0.688 at the twelfth: 1 − 0.9¹¹ = 0.686, 1 − 0.9¹² = 0.718.
/// let first = (1..100).find(|_| ewma.update(&[], &[0.0, -0.2]).alarm());
/// assert_eq!(first, Some(12));
/// ewma.reset();
/// assert!(!ewma.update(&[], &[0.0, -0.2]).alarm());
/// ```
pub trait Detector<T: Scalar = f64>: Stage<T> {
    /// Number of inputs `u`, or `None` if any number will do, including zero.
    fn nu(&self) -> Option<usize> {
        None
    }

    /// Residual channels this detector was built for.
    fn residual_len(&self) -> usize;

    /// Consumes the residual of one sample, next to the input of the same sample.
    fn update(&mut self, u: &[T], r: &[T]) -> Verdict<T>;

    /// Whether, at the last sample, the inputs were beyond anything that the threshold was set on, so that it
    /// states no rate of false alarms. Verdicts go on; the pipeline tells when this begins and ends by the events
    /// [`ThresholdVoid`](crate::EventKind::ThresholdVoid) and [`ThresholdValid`](crate::EventKind::ThresholdValid).
    /// Detectors that do not look at the inputs cannot know, and say no.
    fn is_void(&self) -> bool {
        false
    }
}

/// A test statistic and the threshold that it is compared with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict<T> {
    /// Value of the test statistic.
    pub statistic: T,
    /// Largest value that counts as normal, in the unit of the statistic.
    pub threshold: T,
}

impl<T: Scalar> Verdict<T> {
    /// Whether the statistic is above the threshold. NaN is not.
    #[must_use]
    pub fn alarm(&self) -> bool {
        self.threshold < self.statistic
    }
}
