//! What can go wrong while sizes and samples are checked. Nothing here can occur inside a stage.

use thiserror::Error;

use crate::dims::Shape;

/// A matrix does not have the size its role demands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("{role} must be {expected}, got {found}")]
pub struct ShapeError {
    /// Role of the matrix, such as `"observer gain L"`.
    pub role: &'static str,
    /// Size demanded by the other matrices.
    pub expected: Shape,
    /// Size that was given.
    pub found: Shape,
}

/// A sample cannot become a [`Frame`](crate::Frame).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum FrameError {
    /// A signal has the wrong number of channels.
    #[error("sample {k}: {signal} has {found} channels, expected {expected}")]
    Length {
        /// Sample index.
        k: u64,
        /// `"u"` or `"y"`.
        signal: &'static str,
        /// Channels the stages were built for.
        expected: usize,
        /// Channels that arrived.
        found: usize,
    },
    /// A channel holds a NaN or an infinity.
    #[error("sample {k}: {signal}[{channel}] is not finite")]
    NonFinite {
        /// Sample index.
        k: u64,
        /// `"u"` or `"y"`.
        signal: &'static str,
        /// Index of the channel.
        channel: usize,
    },
}

/// Two stages of a pipeline do not fit together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("{stage} expects {expected} {signal} channels, the residual generator has {found}")]
pub struct BuildError {
    /// Stage that does not fit.
    pub stage: &'static str,
    /// `"input"` or `"residual"`.
    pub signal: &'static str,
    /// Channels the stage was built for.
    pub expected: usize,
    /// Channels of the residual generator.
    pub found: usize,
}
