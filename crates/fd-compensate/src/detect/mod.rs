//! From compensated residuals to test statistics.
//!
//! A detector sees `r*` in every phase, also the innovation of the training; the
//! [decision rule](crate::decide) is what is mute while training.

mod error;
mod magnitude;

pub use self::{
    error::DetectorError,
    magnitude::{DEFAULT_MARGIN, Magnitude},
};
