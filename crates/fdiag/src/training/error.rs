//! Errors that stop a run.

use fd_compensate::{RowsError, decide::RuleError, residual_compensation::CompensationError};
use fd_core::{BuildError, FrameError, LimitError};
use fd_ident::IdentError;
use fd_model::ModelError;
use fd_residual::DesignError;
use thiserror::Error;

use crate::spec::{DetectorSpecError, GeneratorSpecError, IsolationSpecError};

/// A diagnosis cannot be trained or run.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TrainingError {
    /// A log has other channels than the model.
    #[error("the model has {expected} {signal} channels, the log has {found}")]
    Channels {
        /// `"input"` or `"output"`.
        signal: &'static str,
        /// Channels of the model.
        expected: usize,
        /// Channels of the log.
        found: usize,
    },
    /// There is no healthy log.
    #[error("at least one healthy log is needed to learn from")]
    NoHealthyLog,
    /// A log is too short for what is to be done with it.
    #[error("{what} needs at least {needed} complete samples, found {found}")]
    TooShort {
        /// What is to be done.
        what: &'static str,
        /// Least number of samples.
        needed: usize,
        /// Samples there are.
        found: usize,
    },
    /// A setting is out of its range.
    #[error("{setting} must be {expected}, got {found}")]
    Setting {
        /// Name of the setting in the spec.
        setting: &'static str,
        /// What is expected.
        expected: &'static str,
        /// Value that was given.
        found: f64,
    },
    /// Recursive learning was asked for over several logs.
    #[error(
        "recursive learning runs over one log in order of time, got {found}; use batch learning"
    )]
    RecursiveNeedsOneLog {
        /// Healthy logs given.
        found: usize,
    },
    /// A way of learning is not there for a structure of the bias.
    #[error("bias.learning `{learning}` does not go with bias.structure `{structure}`")]
    NotTogether {
        /// Kind of learning.
        learning: &'static str,
        /// Kind of structure.
        structure: &'static str,
    },
    /// The bias did not converge within the healthy log.
    #[error(
        "the bias model did not converge within the {samples} samples of the healthy log: \
         give a longer log, or relax compensation.convergence"
    )]
    NotConverged {
        /// Samples of the log.
        samples: usize,
    },
    /// A diagnosis that starts in training did not get beyond it in the healthy logs.
    #[error(
        "start = \"training\": the switch did not open in any healthy log (of {samples} samples at \
         most), so there is no threshold: give a longer log, or relax compensation.convergence"
    )]
    NeverOpened {
        /// Samples of the longest log.
        samples: usize,
    },
    /// No order could be fitted.
    #[error("no bias model of order 1 to {most} could be fitted to the healthy logs")]
    NoOrder {
        /// Highest order tried.
        most: usize,
    },
    /// The learned bias model is unstable, so it cannot be simulated.
    #[error(
        "the learned bias model is unstable (largest pole {radius:.6}): choose another order, \
         more excitation, or a prefilter"
    )]
    UnstableBias {
        /// Largest magnitude of a pole.
        radius: f64,
    },
    /// A setting is beyond a limit.
    #[error(transparent)]
    Limit(#[from] LimitError),
    /// The model itself.
    #[error("model: {0}")]
    Model(#[from] ModelError),
    /// The residual generator.
    #[error("residual generator: {0}")]
    Generator(#[from] DesignError),
    /// The residual generator of a nonlinear model.
    #[error("residual generator: {0}")]
    Nonlinear(Box<GeneratorSpecError>),
    /// The identification of the bias.
    #[error("bias model: {0}")]
    Bias(#[from] IdentError),
    /// The compensator.
    #[error("compensation: {0}")]
    Compensation(#[from] CompensationError),
    /// Samples for the detector.
    #[error("fault-free residual: {0}")]
    Rows(#[from] RowsError),
    /// The detector.
    #[error("detector: {0}")]
    Detector(#[from] DetectorSpecError),
    /// The decision rule.
    #[error("isolation: {0}")]
    Isolation(#[from] IsolationSpecError),
    /// The decision rule.
    #[error("rule: {0}")]
    Rule(#[from] RuleError),
    /// The stages do not fit together.
    #[error("pipeline: {0}")]
    Build(#[from] BuildError),
    /// A sample of a log.
    #[error("log: {0}")]
    Frame(#[from] FrameError),
}

impl From<GeneratorSpecError> for TrainingError {
    fn from(error: GeneratorSpecError) -> Self {
        match error {
            GeneratorSpecError::Design(error) => Self::Generator(error),
            other => Self::Nonlinear(Box::new(other)),
        }
    }
}
