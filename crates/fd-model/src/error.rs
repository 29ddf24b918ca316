//! What can go wrong with a model or a record.

use fd_core::ShapeError;
use thiserror::Error;

/// A model or record cannot be built or transformed.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ModelError {
    /// The matrices or signals do not fit together.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// The time between samples is not a positive number.
    #[error("sample time must be positive and finite, got {seconds} s")]
    SampleTime {
        /// Value that was given.
        seconds: f64,
    },
    /// A record or model has no output channel.
    #[error("at least one output channel is needed, got none")]
    NoOutputs,
    /// A matrix holds a NaN or an infinity.
    #[error("{role}[{row}, {col}] must be finite, got {value}")]
    NonFinite {
        /// Role of the matrix.
        role: &'static str,
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        col: usize,
        /// Value that was found.
        value: f64,
    },
    /// A decomposition gave up.
    #[error("{what} of the {order}-state model did not converge")]
    NoConvergence {
        /// What was computed.
        what: &'static str,
        /// Number of states.
        order: usize,
    },
    /// The operation needs a stable model.
    #[error("{what} needs a stable model, but there is an eigenvalue at {re} {im:+}i")]
    Unstable {
        /// What was computed.
        what: &'static str,
        /// Real part of the worst eigenvalue (1/s, or per sample for discrete models).
        re: f64,
        /// Imaginary part.
        im: f64,
    },
    /// A matrix that has to be inverted is singular to working precision.
    #[error("{role} is singular to working precision")]
    Singular {
        /// Role of the matrix.
        role: &'static str,
    },
    /// The algebraic equations of a descriptor model do not determine the states that have no rate.
    #[error(
        "a model of index two or more: of {algebraic} states without a rate the algebraic equations determine only \
         {solved}, so that outputs may contain derivatives of inputs; eliminate doubled states or differentiate the constraint"
    )]
    HighIndex {
        /// States without a rate.
        algebraic: usize,
        /// How many of them the algebraic equations determine.
        solved: usize,
    },
    /// Two models with different sample times were connected.
    #[error("sample times must agree, expected {expected} s, found {found} s")]
    SampleTimeMismatch {
        /// Sample time of the first model, in seconds.
        expected: f64,
        /// Sample time of the second model, in seconds.
        found: f64,
    },
    /// More states were asked for than the model has to give.
    #[error("order {requested} is not possible: only {available} {what}")]
    Order {
        /// Order that was asked for.
        requested: usize,
        /// Largest order that is possible.
        available: usize,
        /// What is limited.
        what: &'static str,
    },
    /// A state index is out of range or occurs twice.
    #[error("state {index} cannot be kept: it {why} ({states} states)")]
    StateIndex {
        /// Index, from 0.
        index: usize,
        /// Number of states.
        states: usize,
        /// What is wrong with it.
        why: &'static str,
    },
    /// No gain can make the loop stable, or the problem is too close to such a one.
    #[error("{what} has no stabilising solution: a closed-loop eigenvalue stays at {re} {im:+}i")]
    NotStabilisable {
        /// What was solved.
        what: &'static str,
        /// Real part of the worst closed-loop eigenvalue.
        re: f64,
        /// Imaginary part.
        im: f64,
    },
    /// A weight is not symmetric positive (semi)definite.
    #[error("{role} must be symmetric positive {needed}")]
    NotPositive {
        /// Role of the weight.
        role: &'static str,
        /// `"definite"` or `"semidefinite"`.
        needed: &'static str,
    },
    /// A number is outside the range in which it means something.
    #[error("{role} must lie in {range}, got {value}")]
    OutOfRange {
        /// Role of the number, with its unit.
        role: &'static str,
        /// Range in interval notation.
        range: &'static str,
        /// Value that was given.
        value: f64,
    },
    /// No stable model turned up among the random ones.
    #[error("none of {draws} perturbed models was stable; the perturbation is too large")]
    NoStableDraw {
        /// Number of models that were drawn.
        draws: usize,
    },
}
