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
    /// Where that size lies with the probability that the rule was set to, if it says.
    pub size_interval: Option<[T; 2]>,
    /// Probability of that hypothesis, or, without one, that there is a fault at all; if the rule knows.
    pub confidence: Option<T>,
}

impl<T> Fault<T> {
    /// A fault of which nothing is known but since when it alarms.
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
