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
}
