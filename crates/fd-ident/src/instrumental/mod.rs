//! Instrumental variables: estimates that measurement noise does not bias.
//!
//! ```text
//! least squares:  Σ φ (μ − φᵀθ) = 0          biased: φ holds noisy past μ
//! instruments:    Σ z (μ − φᵀθ) = 0          unbiased when z is correlated with φ, not with the noise
//! ```
//!
//! Source: Söderström & Stoica (1983), *Instrumental variable methods for system identification*;
//! Ljung (1999), eq. (7.108) to (7.123). More instruments than parameters are combined by
//! two-stage least squares.
//!
//! | [`Instruments`] | `z` in place of past `μ` | valid for |
//! |---|---|---|
//! | `DelayedInputs` | older inputs | any noise; needs a lively input |
//! | `DelayedOutputs` | older `μ` | equation noise that is a moving average no longer than the lag |
//! | `Simulated` | `μ̂` of a model fitted before | any noise; the best of the three |
//!
//! [`RecursiveIv`] is the last one sample by sample, an [`Identifier`](fd_core::stage::Identifier).
//! [`Sriv`](crate::refine::Sriv) also filters the signals, which gives minimum variance in white measurement
//! noise: prefer it for batches.
//!
//! # When not to use it
//!
//! Noise-free data (least squares is exact and better conditioned), short records (the variance
//! grows before the bias is gone), and inputs that react to the residual (feedback makes the
//! inputs depend on the noise).

mod batch;
mod recursive;
mod stability;

pub(crate) use self::batch::two_stage;
pub use self::{
    batch::{InstrumentalVariables, Instruments},
    recursive::{IvDesign, RecursiveIv},
};
