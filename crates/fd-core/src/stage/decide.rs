//! From verdicts to decisions.

use serde::{Deserialize, Serialize};

use crate::{
    scalar::Scalar,
    stage::{Phase, Stage, Verdict},
};

/// Turns the evidence of one sample into a decision.
pub trait DecisionRule<T: Scalar = f64>: Stage<T> {
    /// Residual channels this rule was built for.
    fn residual_len(&self) -> usize;

    /// Judges one sample.
    fn decide(&mut self, evidence: Evidence<'_, T>) -> Decision<T>;
}

/// Everything a rule may look at.
#[derive(Clone, Copy, Debug)]
pub struct Evidence<'a, T> {
    /// Sample index.
    pub k: u64,
    /// Phase of the compensator.
    pub phase: Phase,
    /// What the detector saw.
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
}

impl<T> Decision<T> {
    /// Whether a fault is reported.
    #[must_use]
    pub fn is_fault(&self) -> bool {
        matches!(self, Self::Fault(_))
    }
}
