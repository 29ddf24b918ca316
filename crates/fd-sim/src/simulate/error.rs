//! Why a model cannot be simulated or linearised.

use fd_model::ModelError;
use thiserror::Error;

use crate::equation::CompileError;

/// A model cannot be simulated or linearised.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SimulateError {
    /// The equations cannot be compiled.
    #[error(transparent)]
    Compile(#[from] CompileError),
    /// A linear model cannot be built.
    #[error(transparent)]
    Linear(#[from] ModelError),
    /// The Jacobian has no finite value at the initial state, so no step can be derived from it.
    #[error(
        "the derivative of `{state}` has no finite slope at the initial state with all inputs zero (is it divided by \
         an input?), so that no integration step follows from it: state `step` in the model"
    )]
    NoStep {
        /// First state with such a derivative.
        state: String,
    },
    /// The step is so short that a simulation would take too long.
    #[error(
        "{substeps} integration steps per sample of {ts} s are needed, at most {most} are allowed \
         (limit `substeps`)"
    )]
    TooStiff {
        /// Steps needed.
        substeps: f64,
        /// Time between samples, in seconds.
        ts: f64,
        /// Most that are allowed.
        most: u64,
    },
    /// The rates of controller and log do not fit.
    #[error(
        "the controller acts every {controller} s and samples come every {ts} s: one must be a multiple of the other"
    )]
    ControllerRate {
        /// Time between two actions, in seconds.
        controller: f64,
        /// Time between samples, in seconds.
        ts: f64,
    },
    /// The model does not have the kind of states that the operation needs.
    #[error("{operation} needs {needed}; `{state}` is another kind of state")]
    Kind {
        /// What was asked.
        operation: &'static str,
        /// What it needs.
        needed: &'static str,
        /// First state that does not fit.
        state: String,
    },
    /// A sampled controller has no place in a continuous linear model.
    #[error(
        "a sampled controller cannot be linearised in continuous time: remove it or make it continuous"
    )]
    SampledController,
    /// A delay has no finite linear model.
    #[error("the delay `{delay}` has no linear model with a finite number of states")]
    Delay {
        /// Name of the delayed value.
        delay: String,
    },
    /// Something that remembers more than states can say, so that there is no map from state to state.
    #[error(
        "`{name}` is {what}, which remembers more than states: there is no map from state to state"
    )]
    Remembers {
        /// Kind of entry.
        what: &'static str,
        /// Name of the entry.
        name: String,
    },
    /// A black box that steps at another rate than the log.
    #[error(
        "the simulator steps every {own} s and samples come every {ts} s: it must step a whole number of times per sample"
    )]
    Rate {
        /// Time between steps of the simulator, in seconds.
        own: f64,
        /// Time between samples, in seconds.
        ts: f64,
    },
    /// A model that is not the shell of this simulator with effects in it.
    #[error("the model is not that of this shell: it has no {what} `{name}`")]
    NotThisShell {
        /// Kind of entry.
        what: &'static str,
        /// Name of the entry.
        name: String,
    },
    /// A part of a model is not a correct model.
    #[error(transparent)]
    Model(#[from] crate::model::ModelError),
    /// A part of the model is beyond a limit.
    #[error(transparent)]
    Limit(#[from] fd_core::LimitError),
    /// Numbers of values do not match the model.
    #[error("{what}: expected {expected} values, got {found}")]
    Length {
        /// Which values.
        what: &'static str,
        /// How many the model has.
        expected: usize,
        /// How many were given.
        found: usize,
    },
}
