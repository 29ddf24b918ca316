//! Identification of bias models: how the bias of a residual follows from the inputs.
//!
//! Unmodelled effects leave a bias `μ` in the residual that depends on the input. This crate
//! finds that dependence from fault-free data, eq. (13) to (18) of Patton & Chen (1992), so that
//! it can be subtracted.
//!
//! | room | what it holds |
//! |---|---|
//! | [`arx`] | difference equations: fit, identify on line, simulate, analyse |
//! | [`least_squares`] | batch least squares with rank and condition |
//! | [`rls`] | recursive least squares with forgetting and safeguards |
//! | [`order`] | which orders? |
//! | [`diagnostics`] | is anything left in the residuals of a fit? |
//! | [`refine`] | options for noisy residuals |
//! | [`instrumental`] | instrumental variables, in batches and on line |
//! | [`extended`] | extended least squares for moving-average noise (ARMAX) |
//! | [`prediction_error`] | output error, Box-Jenkins and ARMAX by Gauss-Newton |
//! | [`subspace`] | one state-space model for several residuals at once |
//! | [`hammerstein`] | a static nonlinearity before the dynamics |
//! | [`scheduled`] | local models, blended over the operating range |
//! | [`random_walk`] | recursive least squares as a Kalman filter |
//!
//! [`RecursiveArx`](arx::RecursiveArx) is an [`Identifier`](fd_core::stage::Identifier),
//! [`ArxSimulator`](arx::ArxSimulator) a [`BiasModel`](fd_core::stage::BiasModel).
//!
//! # When not to use it
//!
//! When a fault may be present in the training data: it would be learned as bias. When the cause
//! of the bias is known, model the cause instead.

mod error;

pub mod arx;
pub mod batch;
pub mod diagnostics;
pub mod extended;
pub mod hammerstein;
pub mod instrumental;
pub mod least_squares;
pub mod order;
pub mod prediction_error;
pub mod random_walk;
pub mod refine;
pub mod rls;
pub mod scheduled;
pub mod subspace;

pub use crate::error::IdentError;
