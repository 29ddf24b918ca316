//! Arithmetic that several crates share, in one place, so that results are bit-identical wherever it is used.
//!
//! | To | use |
//! |---|---|
//! | multiply short vectors at run time, in any precision | [`dot()`] |
//! | multiply long signals | [`wide::dot`], [`wide::dots`] |
//! | compute with many numbers side by side (SIMD) | [`lanes`] |
//! | measure the size of a signal | [`rms()`] |
//! | order samples | [`quantile()`], [`median`], [`upper_median`], [`robust_deviation`] |

mod dot;
pub mod lanes;
mod quantile;
mod rms;
pub mod wide;

pub use crate::{
    dot::dot,
    quantile::{median, quantile, robust_deviation, upper_median},
    rms::rms,
};
