//! Arithmetic that several crates share, in one place, so that results are bit-identical wherever it is used.
//!
//! | To | use |
//! |---|---|
//! | multiply short vectors at run time, in any precision | [`dot()`] |
//! | multiply long signals | [`wide::dot`], [`wide::dots`] |
//! | decompose and solve (in `f64`) | [`dense`] |
//! | compute with many numbers side by side (SIMD) | [`lanes`] |
//! | find the lines of a signal | [`fourier`] |
//! | measure the size of a signal | [`rms()`], [`mean_and_deviation`] |
//! | order samples | [`quantile()`], [`median`], [`upper_median`], [`robust_deviation`] |
//!
//! One wrong sample changes the size of a residual, not its median:
//!
//! ```
//! use fd_numeric::{dot, median, rms};
//!
//! let mut residual = vec![0.1, -0.1, 0.1, 90.0, -0.1, 0.1, 0.1];
//! assert!(30.0 < rms(residual.iter().copied()));
//! assert_eq!(median(&mut residual), 0.1);
//! assert_eq!(dot(&[1.0, 2.0], &[3.0, 4.0]), 11.0);
//! ```

pub mod dense;
mod dot;
pub mod fourier;
pub mod lanes;
mod quantile;
mod rms;
pub mod wide;

pub use crate::{
    dot::dot,
    quantile::{median, quantile, robust_deviation, upper_median},
    rms::{mean_and_deviation, rms},
};
