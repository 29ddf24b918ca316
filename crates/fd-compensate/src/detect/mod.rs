//! From compensated residuals to test statistics.
//!
//! | Detector | Statistic | Good for |
//! |----------|-----------|----------|
//! | [`Magnitude`] | norm of `r_i / s_i`, by default the largest | the paper's rule; abrupt faults, no assumption on noise |
//! | [`NSigma`] | largest `(r_i − m_i) / σ_i` | the same with an offset, in standard deviations |
//! | [`ChiSquare`] | `Σ (r − m)ᵀ Σ⁻¹ (r − m)` over a window | several correlated channels |
//! | [`Cusum`] | two-sided cumulative sum, worst channel | small lasting faults |
//! | [`Sprt`] | log-likelihood ratio of Wald's restarted test | lasting faults of a known least size |
//! | [`Glr`] | generalised likelihood ratio over onsets and sizes | unknown time and size, also with known signatures; gives both |
//! | [`TwoSample`] | mean, variance or distribution of a window against fault-free | dead or noisy sensors, changes of shape |
//! | [`AdaptiveThreshold`] | residual against a bound that follows the input | uncompensated bias of a wrong model |
//!
//! A detector sees `r*` in every phase, also the innovation of the training; the
//! [decision rule](crate::decide) is what is mute while training. Detectors with a memory (a window, a
//! sum) therefore carry the last innovations into the first compensated samples.
//!
//! The thresholds that the constructors compute from a formula assume white Gaussian residuals, which
//! a compensated residual seldom is. [`calibrate`](crate::calibrate) finds thresholds from fault-free
//! data instead.

pub mod adaptive;
pub mod chi_square;
pub mod cusum;
pub(crate) mod error;
pub mod glr;
mod magnitude;
mod n_sigma;
mod quadrature;
pub mod sprt;
mod standardize;
pub mod two_sample;
pub mod whiten;

pub use self::{
    adaptive::AdaptiveThreshold,
    chi_square::ChiSquare,
    cusum::Cusum,
    error::DetectorError,
    glr::Glr,
    magnitude::{DEFAULT_MARGIN, Magnitude, Norm},
    n_sigma::NSigma,
    sprt::Sprt,
    standardize::{Spread, Standardizer},
    two_sample::TwoSample,
};
