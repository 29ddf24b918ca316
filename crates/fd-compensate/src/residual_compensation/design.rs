//! The plan of a compensator: every choice of the two-stage method, with defaults.

use serde::{Deserialize, Serialize};

use super::{error::CompensationError, plant_change::PlantChange};
use crate::rows::SampleRows;

/// Every choice of the two-stage method.
///
/// ```
/// use fd_compensate::residual_compensation::{CompensationPlan, Mode};
///
/// let plan = CompensationPlan::default();
/// assert_eq!(plan.mode, Mode::Simulation);
/// assert!(plan.check().is_ok());
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CompensationPlan {
    /// How `μ̂` is computed once the parameters are frozen.
    pub mode: Mode,
    /// When training ends.
    pub convergence: Convergence,
    /// How a candidate `θ*` is tried before the switch opens, and watched afterwards.
    pub trial: Trial,
    /// The alarm for hard faults during training.
    pub hard_fault: HardFault,
    /// The guard of the trained operating range.
    pub operating_point: OperatingPoint,
    /// The watch for a plant that changes while its operating range stays.
    pub plant_change: PlantChange,
    /// Whether either of the two only asks to train again, by events, instead of doing it; default false. A bias
    /// model that diverges is learned again without asking: nothing could be compensated with it.
    pub ask: bool,
}

/// How `μ̂` is computed once the parameters are frozen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mode {
    /// From `u` and its own past alone (eq. 16): no fault can leak into it.
    #[default]
    Simulation,
    /// From `u` and past measured residuals, for comparison only: a fault `f_r` is left as
    /// `A(z) f_r`, see the [module](super).
    OneStep,
}

/// When training ends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Convergence {
    /// Which test ends it; default [`ConvergenceRule::InARow`].
    pub rule: ConvergenceRule,
    /// With the rule `in-a-row`: `ε` of the test `‖θ(k+1) − θ(k)‖ ≤ ε ‖θ(k)‖`; default 1e-3. A smaller one mostly buys time:
    /// for a second-order bias under white noise of 1 % of its peak, recursive least squares passes
    /// 1e-3 after 3 000 to 10 000 samples and 1e-4 not within 20 000, while what is left of the bias
    /// is the same within some per cent from 3e-3 on.
    pub tolerance: f64,
    /// With the rule `in-a-row`: samples in a row that must pass the test, more than the order of the bias
    /// model; default 50.
    pub consecutive: u64,
    /// Least samples learned from, counted without those that the identifier skipped; default 200.
    pub least_samples: u64,
    /// Longest training in samples; default none.
    pub longest: Option<u64>,
    /// What follows a training that did not converge.
    pub at_longest: Timeout,
    /// At least one input channel must have moved by more than this, in its unit; default 0, so a
    /// constant input never ends a training.
    pub least_input_span: f64,
    /// Bound on `√(Σ var θᵢ) σ / ‖θ‖` with `σ` the rms innovation of the worst channel: the standard
    /// error of the whole parameter vector relative to its norm; default none.
    pub relative_standard_error: Option<f64>,
}

impl Default for Convergence {
    fn default() -> Self {
        Self {
            rule: ConvergenceRule::default(),
            tolerance: 1e-3,
            consecutive: 50,
            least_samples: 200,
            longest: None,
            at_longest: Timeout::default(),
            least_input_span: 0.0,
            relative_standard_error: None,
        }
    }
}

/// Which test ends a training; the other settings of [`Convergence`] are demanded besides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum ConvergenceRule {
    /// `‖θ(k+1) − θ(k)‖ ≤ ε ‖θ(k)‖` in so many samples in a row, with `tolerance` as `ε` and `consecutive`.
    #[default]
    InARow,
    /// The paper's test with its two small constants, in one sample: `‖θ(k+1) − θ(k)‖ ≤ ε ‖θ(k)‖` and
    /// `‖θ(k+1) − θ(k)‖ ≤ μ`. How the garbled print is read is said [above](super).
    TwoConstants {
        /// `ε`, bound of the relative change.
        epsilon: f64,
        /// `μ`, bound of the change itself, in the units of `θ`.
        mu: f64,
    },
}

/// What follows a training that reached its longest duration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Timeout {
    /// Forget everything and train again.
    #[default]
    TrainAgain,
    /// Freeze what has been learned, without a trial.
    FreezeAnyway,
}

/// How a candidate `θ*` is tried before the switch opens, and watched afterwards.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Trial {
    /// Samples over which the candidate is simulated next to the healthy residual before it is
    /// accepted; 0 freezes at once; default 50.
    pub samples: u64,
    /// Largest `rms(r − μ̂) / rms(r)` over the trial, for each channel; default 1.1: compensation
    /// must not make anything noticeably worse. Lower it to demand a success.
    pub worst_ratio: f64,
    /// After freezing: largest `|μ̂|` as a multiple of the largest `|r|` of the training, over all
    /// channels; default 100. Beyond it the model has diverged and training starts again.
    pub divergence: f64,
}

impl Default for Trial {
    fn default() -> Self {
        Self { samples: 50, worst_ratio: 1.1, divergence: 100.0 }
    }
}

/// The alarm for hard faults during training: large and abrupt jumps of the innovation.
///
/// An input outside the range of the training so far (by more than the margins of
/// [`OperatingPoint`]) starts the warm-up again: what the innovation then does is no evidence.
///
/// A channel jumps when its innovation exceeds both `factor` times its running mean magnitude and
/// `least_jump` times the largest residual of the training. Adaptation then pauses: `μ̂` is
/// simulated with the last parameters, and training starts afresh once the jumped channels have
/// been back within half the jump for `resume_after` samples, or as [`Convergence::at_longest`] says
/// once the longest training is over; with [`Timeout::FreezeAnyway`] a fault that is still there then
/// shows in `r*`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct HardFault {
    /// Whether to watch for hard faults; default true.
    pub watch: bool,
    /// Jump relative to the running mean magnitude of the innovation; default 10.
    pub factor: f64,
    /// Jump relative to the largest `|r|` of the training so far; default 0.5.
    pub least_jump: f64,
    /// Time constant of the running mean magnitude, in samples; default 50.
    pub memory: f64,
    /// Samples of training before the test is made; default 100.
    pub warm_up: u64,
    /// Samples in a row without the jump before training starts again; default 20.
    pub resume_after: u64,
}

impl Default for HardFault {
    fn default() -> Self {
        Self {
            watch: true,
            factor: 10.0,
            least_jump: 0.5,
            memory: 50.0,
            warm_up: 100,
            resume_after: 20,
        }
    }
}

/// The guard of the trained operating range.
///
/// A low-passed copy of each input is compared with the range of that input in training, widened
/// by the margins. It is left beyond the margins and regained within half of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OperatingPoint {
    /// What to do when the range is left; default [`RangePolicy::Warn`].
    pub policy: RangePolicy,
    /// Time constant of the low-pass in samples, 0 for none; default 20.
    pub time_constant: f64,
    /// Margin relative to the width of the trained range; default 0.1.
    pub margin: f64,
    /// Margin in the unit of the input, in addition; default 0.
    pub margin_absolute: f64,
}

impl Default for OperatingPoint {
    fn default() -> Self {
        Self {
            policy: RangePolicy::default(),
            time_constant: 20.0,
            margin: 0.1,
            margin_absolute: 0.0,
        }
    }
}

/// What to do when the input leaves the trained range. Events are given in any case but `Ignore`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum RangePolicy {
    /// Do not watch.
    Ignore,
    /// Say so and go on.
    #[default]
    Warn,
    /// Train again at once.
    Retrain,
    /// Train again once the low-passed input has stayed within `band` for `samples` samples outside
    /// the trained range; go on if it comes back before.
    RetrainAfter {
        /// Samples the input must have been settled for.
        samples: u64,
        /// Largest wander that counts as settled, relative to the width of the trained range, plus
        /// the absolute margin.
        band: f64,
    },
}

/// A bias model that was fitted beforehand, with what it was fitted on.
#[derive(Clone, Debug, PartialEq)]
pub struct PreFitted {
    /// Parameters `θ*`, those of residual channel 0 first.
    pub theta: Vec<f64>,
    /// Least value of each input in the training data.
    pub input_low: Vec<f64>,
    /// Largest value of each input in the training data.
    pub input_high: Vec<f64>,
    /// Largest `|r|` over all channels of the training data; `μ̂` beyond `trial.divergence` times this
    /// counts as diverged.
    pub residual_peak: f64,
    /// Samples at the start in which the histories of the model are filled with the measured
    /// residual (phase `Training`, `r* = r`) before it is simulated. Use the order of the model when
    /// a log begins away from `u = 0, r = 0`; the plant must be healthy in these samples.
    pub filling: u64,
}

impl PreFitted {
    /// Takes the ranges from the training data.
    ///
    /// ```
    /// use fd_compensate::{SampleRows, residual_compensation::PreFitted};
    ///
    /// let u = SampleRows::new(1, &[0.0, 1.0, 0.5])?;
    /// let r = SampleRows::new(1, &[0.0, -0.3, 0.1])?;
    /// let fit = PreFitted::from_training(vec![-0.3], u, r);
    /// assert_eq!((fit.input_high[0], fit.residual_peak), (1.0, 0.3));
    /// # Ok::<(), fd_compensate::RowsError>(())
    /// ```
    #[must_use]
    pub fn from_training(theta: Vec<f64>, u: SampleRows<'_>, r: SampleRows<'_>) -> Self {
        Self {
            theta,
            input_low: u.per_channel(|v| v.fold(f64::INFINITY, f64::min)),
            input_high: u.per_channel(|v| v.fold(f64::NEG_INFINITY, f64::max)),
            residual_peak: r.iter().flatten().fold(0.0, |peak: f64, v| peak.max(v.abs())),
            filling: 0,
        }
    }

    /// Sets the samples in which the histories are filled before the model is simulated.
    #[must_use]
    pub fn filling(mut self, samples: u64) -> Self {
        self.filling = samples;
        self
    }

    pub(super) fn check(&self, nu: usize, theta_len: usize) -> Result<(), CompensationError> {
        let lists = [
            ("theta", &self.theta, theta_len),
            ("input_low", &self.input_low, nu),
            ("input_high", &self.input_high, nu),
        ];
        for (part, list, expected) in lists {
            if list.len() != expected {
                let (quantity, found) = ("entries", list.len());
                return Err(CompensationError::Size { part, quantity, expected, found });
            }
            if let Some(index) = list.iter().position(|v| !v.is_finite()) {
                let found = list[index];
                return Err(CompensationError::NonFinite { quantity: part, index, found });
            }
        }
        at_least("residual_peak", self.residual_peak, 0.0)
    }
}

impl CompensationPlan {
    /// Checks all numbers.
    ///
    /// # Errors
    ///
    /// Returns the first number that is out of its range.
    pub fn check(&self) -> Result<(), CompensationError> {
        let Self { convergence, trial, hard_fault, operating_point, plant_change, .. } = self;
        positive("convergence.tolerance", convergence.tolerance)?;
        if let ConvergenceRule::TwoConstants { epsilon, mu } = convergence.rule {
            positive("convergence.rule.epsilon", epsilon)?;
            positive("convergence.rule.mu", mu)?;
        }
        at_least("convergence.least_input_span", convergence.least_input_span, 0.0)?;
        if let Some(bound) = convergence.relative_standard_error {
            positive("convergence.relative_standard_error", bound)?;
        }
        positive("trial.worst_ratio", trial.worst_ratio)?;
        positive("trial.divergence", trial.divergence)?;
        positive("hard_fault.factor", hard_fault.factor)?;
        at_least("hard_fault.least_jump", hard_fault.least_jump, 0.0)?;
        at_least("hard_fault.memory", hard_fault.memory, 1.0)?;
        at_least("operating_point.time_constant", operating_point.time_constant, 0.0)?;
        at_least("operating_point.margin", operating_point.margin, 0.0)?;
        at_least("operating_point.margin_absolute", operating_point.margin_absolute, 0.0)?;
        if let RangePolicy::RetrainAfter { band, .. } = operating_point.policy {
            at_least("operating_point.policy.band", band, 0.0)?;
        }
        plant_change.check()
    }
}

fn positive(parameter: &'static str, found: f64) -> Result<(), CompensationError> {
    let expected = "positive and finite";
    let fine = found > 0.0 && found.is_finite();
    if fine { Ok(()) } else { Err(CompensationError::Parameter { parameter, expected, found }) }
}

fn at_least(parameter: &'static str, found: f64, least: f64) -> Result<(), CompensationError> {
    let expected = if least < 1.0 { "non-negative and finite" } else { "finite and at least 1" };
    let fine = found >= least && found.is_finite();
    if fine { Ok(()) } else { Err(CompensationError::Parameter { parameter, expected, found }) }
}
