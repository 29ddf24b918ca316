//! Why a model cannot be fitted to logs.

use fd_model::RecordError;
use fd_sim::simulate::SimulateError;
use thiserror::Error;

/// A model cannot be fitted to logs.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FitError {
    /// There is nothing to fit to.
    #[error("no log was given")]
    NoLog,
    /// A log has too few measured values for the unknowns of the fit.
    #[error("log {log} has {found} measured values; {unknowns} unknowns need at least {needed}")]
    TooShort {
        /// Number of the log, from 1.
        log: usize,
        /// Measured values in the log.
        found: usize,
        /// Parameters and states to be fitted.
        unknowns: usize,
        /// Values that would do.
        needed: usize,
    },
    /// A channel of the model is not in the log.
    #[error("log {log} has no {role} `{channel}`, only {known:?}")]
    Channel {
        /// Number of the log, from 1.
        log: usize,
        /// `input` or `output`.
        role: &'static str,
        /// Name in the model.
        channel: String,
        /// Names in the log.
        known: Vec<String>,
    },
    /// A channel has a unit that does not fit that of the model.
    #[error("log {log}: {source}")]
    Unit {
        /// Number of the log, from 1.
        log: usize,
        /// Which channel, which units.
        source: RecordError,
    },
    /// An input has no value at all.
    #[error("log {log} has no value of input `{channel}`")]
    EmptyInput {
        /// Number of the log, from 1.
        log: usize,
        /// Name of the input.
        channel: String,
    },
    /// Log and simulator have different sample times.
    #[error("log {log} is sampled every {found} s, the simulator every {expected} s")]
    SampleTime {
        /// Number of the log, from 1.
        log: usize,
        /// Sample time of the simulator, in seconds.
        expected: f64,
        /// Sample time of the log, in seconds.
        found: f64,
    },
    /// A simulator lacks a parameter or state that the fit needs.
    #[error("the simulator has no {what} `{name}`")]
    Missing {
        /// `parameter` or `state`.
        what: &'static str,
        /// Its name.
        name: String,
    },
    /// The nominal simulation has values that are not finite.
    #[error("the simulator diverges with its nominal parameters and initial states")]
    Diverged,
    /// A simulator cannot be built.
    #[error(transparent)]
    Simulate(#[from] SimulateError),
}
