//! Arithmetic that several crates need, each in one place: so that it is the same to the bit wherever
//! it is used.
//!
//! | To | take |
//! |---|---|
//! | multiply short vectors at run time, in any precision | [`dot()`] |
//! | multiply long signals | [`wide::dot`], [`wide::dots`] |
//! | compute the same with many numbers side by side | [`lanes`] |
//! | say how large a signal is | [`rms()`] |
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
