//! What can go wrong while a nonlinear generator is designed.

use fd_model::ModelError;
use fd_sim::simulate::SimulateError;
use thiserror::Error;

/// No such generator exists for this model, or a setting makes no sense.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum NonlinearError {
    /// There is not one number per channel.
    #[error("{what}: expected {expected} values, found {found}")]
    Length {
        /// Which numbers.
        what: &'static str,
        /// How many there are to be.
        expected: usize,
        /// How many were given.
        found: usize,
    },
    /// A number is out of its range.
    #[error("{what} {index}: expected {expected}, found {found}")]
    Number {
        /// What the number is.
        what: &'static str,
        /// Its place, from 1.
        index: usize,
        /// What makes sense.
        expected: &'static str,
        /// What was given.
        found: f64,
    },
    /// A setting is out of its range.
    #[error("{setting}: expected {expected}, found {found}")]
    Setting {
        /// Name of the setting.
        setting: &'static str,
        /// What makes sense.
        expected: &'static str,
        /// What was given.
        found: f64,
    },
    /// The model has no finite value where the filter is to start.
    #[error("the model has no finite {what} at its initial state")]
    NotFinite {
        /// What is not finite.
        what: &'static str,
    },
    /// A simulator that keeps its memory to itself.
    #[error("the simulator cannot show its memory, so that a snapshot could not hold it")]
    NoMemory,
    /// The model cannot be run.
    #[error("model: {0}")]
    Simulate(#[from] SimulateError),
    /// A linear model of it cannot be built.
    #[error("linearisation: {0}")]
    Linear(#[from] ModelError),
}
