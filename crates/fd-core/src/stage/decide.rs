//! From verdicts to decisions.

use serde::{Deserialize, Serialize};

use crate::{
    scalar::Scalar,
    stage::{Phase, Stage, Verdict},
};

/// Turns the evidence of one sample into a decision.
///
/// This is the last stage. The detector says how far from normal this sample is; the rule says whether there is
/// a *fault*, since when, and, if possible, which one and how large. Here single outliers are tolerated, an
/// alarm stays on until the plant has been normal for a while, and the compensated residual is compared with
/// the signatures of known faults.
///
/// # The contract
///
/// * [`decide`](Self::decide) is called once per sample with the [`Evidence`] of that sample and returns a
///   [`Decision`]. The decision describes the present state: a persisting fault is reported at each sample,
///   with the same `since`.
/// * In [`Phase::Training`] a rule reports [`Decision::Nominal`], unless it latches a fault that was found
///   before. A threshold for `r*` does not apply to an innovation, whatever the verdict says.
/// * [`Fault::since`] is the sample of the first alarm that led to the decision, not the sample at
///   which the rule had seen enough. Delays are measured from it.
/// * A field of [`Fault`] that the rule cannot fill is `None`. A confidence is a probability, and a size is in
///   the unit of its hypothesis; do not fill them with guesses.
///
/// # Who calls it, and when
///
/// [`Pipeline::step`](crate::Pipeline::step), last of the four stages. The pipeline turns changes of
/// the decision into the events `AlarmRaised` and `AlarmCleared`, so rules push no events.
///
/// `evidence.k` counts the samples that were accepted or held. A rejected sample never arrives and leaves no
/// gap in `k`, so a rule that counts consecutive samples may count calls.
///
/// # What an implementor must do
///
/// * *Reset counts in training.* What was counted before belongs to a different `r*`.
/// * *Show all memory*: recent alarms, the sample of the first one, sums of the residual.
///   [`visit_state`](super::Stage::visit_state) has `counts` for sample indices. A restored rule clears its
///   alarm at the same sample as one that was never interrupted.
/// * *Neither allocate nor fail.* Hypotheses are prepared when the rule is built: signatures checked,
///   covariances factorised, names kept outside. [`Fault::hypothesis`] is an index into that list.
/// * *Decide from the evidence alone.* No clock, no random numbers: two runs over the same log agree bit for
///   bit.
///
/// # How it composes
///
/// As a type in [`Stages`](crate::Stages), as `Box<dyn DecisionRule>`, or by the tables `[rule]`, `[sizing]`
/// and `[isolation]` of a spec. A rule may hold another one: those of `fd-compensate` that isolate faults
/// contain the debouncing rule that detects them. This separates "is there a fault?" from "which one?", and the
/// answer to the first does not depend on whether the second is asked.
///
/// # When not to implement it
///
/// For "raise after *m* of *n*, clear after *c*": that is `fd_compensate::decide::Debounce`. For fault sizes
/// from known signatures and for probabilities of hypotheses there are `SizedDebounce` and `IsolatingDebounce`.
/// For an action (shut down, call somebody) write a [`Sink`](crate::Sink): a rule decides what is the case, not
/// what to do about it.
///
/// # Example
///
/// A fault is reported after three alarms in a row and persists until one sample is normal; the largest channel
/// of `r*` identifies the sensor:
///
/// ```
/// use fd_core::{
///     StateVisitor,
///     stage::{Decision, DecisionRule, Evidence, Fault, Phase, Stage, Verdict},
/// };
///
/// #[derive(Debug, Default)]
/// struct ThreeInARow {
///     alarms: u64,
/// }
///
/// impl Stage for ThreeInARow {
///     fn reset(&mut self) {
///         self.alarms = 0;
///     }
///
///     fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
///         visitor.counts("alarms in a row", std::slice::from_mut(&mut self.alarms));
///     }
/// }
///
/// impl DecisionRule for ThreeInARow {
///     fn residual_len(&self) -> usize {
///         2
///     }
///
///     fn decide(&mut self, evidence: Evidence<'_, f64>) -> Decision<f64> {
///         let counts = evidence.phase == Phase::Compensating && evidence.verdict.alarm();
///         self.alarms = if counts { self.alarms + 1 } else { 0 };
///         if self.alarms < 3 {
///             return Decision::Nominal;
///         }
///         let [a, b] = [evidence.r_star[0].abs(), evidence.r_star[1].abs()];
///         Decision::Fault(Fault {
///             hypothesis: Some(usize::from(b > a)),
///             ..Fault::since(evidence.k + 1 - self.alarms)
///         })
///     }
/// }
///
/// let mut rule = ThreeInARow::default();
/// let mut decide = |k: u64, phase| {
///     // Sample 2 is an outlier; from sample 5 on the second sensor is off.
///     let r_star: [f64; 2] = if k == 2 || k >= 5 { [0.1, -4.0] } else { [0.1, 0.2] };
///     let verdict = Verdict { statistic: r_star[1].abs(), threshold: 1.0 };
///     rule.decide(Evidence { k, phase, verdict, r_star: &r_star })
/// };
/// let first = (0..20).find(|&k| decide(k, Phase::Compensating).is_fault());
/// assert_eq!(first, Some(7));
/// let Decision::Fault(fault) = decide(8, Phase::Compensating) else { unreachable!() };
/// assert_eq!((fault.since, fault.hypothesis), (5, Some(1)));
///
/// assert!(!decide(9, Phase::Training { samples: 0 }).is_fault(), "nothing is judged in training");
/// assert!(!decide(10, Phase::Compensating).is_fault(), "and the count begins again");
/// ```
pub trait DecisionRule<T: Scalar = f64>: Stage<T> {
    /// Residual channels this rule was built for.
    fn residual_len(&self) -> usize;

    /// Judges one sample.
    fn decide(&mut self, evidence: Evidence<'_, T>) -> Decision<T>;
}

/// Everything a rule may use.
#[derive(Clone, Copy, Debug)]
pub struct Evidence<'a, T> {
    /// Sample index.
    pub k: u64,
    /// Phase of the compensator.
    pub phase: Phase,
    /// The verdict of the detector.
    pub verdict: Verdict<T>,
    /// The compensated residual.
    pub r_star: &'a [T],
}

/// The outcome of one sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Decision<T> {
    /// Nothing to report.
    Nominal,
    /// A fault is present.
    Fault(Fault<T>),
}

/// What is known of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fault<T> {
    /// Sample of the first alarm that led to this decision.
    pub since: u64,
    /// Which of the hypotheses of the rule explains it best, if the rule has any.
    pub hypothesis: Option<usize>,
    /// Estimated size in the unit of that hypothesis, if it can be estimated.
    pub size: Option<T>,
    /// Interval that contains the size with the probability set in the rule, if available.
    pub size_interval: Option<[T; 2]>,
    /// Probability of that hypothesis, or, without one, that there is a fault at all; if the rule knows.
    pub confidence: Option<T>,
}

impl<T> Fault<T> {
    /// A fault of which only the first alarm is known.
    ///
    /// ```
    /// use fd_core::stage::Fault;
    ///
    /// assert_eq!(Fault::<f64>::since(7).hypothesis, None);
    /// ```
    #[must_use]
    pub const fn since(since: u64) -> Self {
        Self { since, hypothesis: None, size: None, size_interval: None, confidence: None }
    }
}

impl<T> Decision<T> {
    /// Whether a fault is reported.
    #[must_use]
    pub fn is_fault(&self) -> bool {
        matches!(self, Self::Fault(_))
    }
}
