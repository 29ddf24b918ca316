//! What a pipeline is made of, what it is told about missing samples, and what it gives.

use crate::{
    event::Events,
    stage::{Compensator, Decision, DecisionRule, Detector, Phase, ResidualGenerator, Verdict},
};

/// The parts of a [`Pipeline`](super::Pipeline), named so that a pipeline reads top to bottom.
#[derive(Clone, Debug)]
pub struct Stages<G, C, D, J> {
    /// Samples to primary residuals.
    pub generator: G,
    /// Primary to compensated residuals.
    pub compensator: C,
    /// Compensated residuals to test statistics.
    pub detector: D,
    /// Test statistics to decisions.
    pub rule: J,
}

/// Stages chosen at run time.
pub type DynStages<T = f64> = Stages<
    Box<dyn ResidualGenerator<T>>,
    Box<dyn Compensator<T>>,
    Box<dyn Detector<T>>,
    Box<dyn DecisionRule<T>>,
>;

/// What to do with a sample that has a NaN or an infinity in it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MissingSamples {
    /// Refuse it with an error; the pipeline stays as it was.
    #[default]
    Reject,
    /// Replace each missing channel by its last good value, for at most this many samples in a
    /// row; then refuse.
    Hold {
        /// Most consecutive samples to replace.
        at_most: u64,
    },
}

/// Everything that one sample produced, borrowed from the pipeline.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a, T> {
    /// Sample index.
    pub k: u64,
    /// Primary residual `r`.
    pub residual: &'a [T],
    /// Compensated residual `r* = r − μ̂`.
    pub compensated: &'a [T],
    /// Whether the bias is being learned or subtracted.
    pub phase: Phase,
    /// Test statistic of the compensated residual.
    pub verdict: Verdict<T>,
    /// Outcome.
    pub decision: Decision<T>,
    /// What happened at this sample.
    pub events: Events,
}
