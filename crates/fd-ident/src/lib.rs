//! Identification of bias models: how the bias of a residual follows from the inputs.
//!
//! Unmodelled effects leave a bias `μ` in the residual that depends on the input. This crate
//! finds that dependence from fault-free data, eq. (13) to (18) of Patton & Chen (1992), so that
//! it can be subtracted.
//!
//! | module | what it holds |
//! |---|---|
//! | [`arx`] | difference equations: fit, identify on line, simulate, analyse |
//! | [`least_squares`] | batch least squares with rank and condition |
//! | [`rls`] | recursive least squares with forgetting and safeguards |
//! | [`order`] | selection of orders |
//! | [`diagnostics`] | tests of the residuals of a fit |
//! | [`refine`] | prefilters and other options for noisy residuals |
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
//! The same equation is fitted to a log, learned sample by sample, and run:
//!
//! ```
//! use fd_core::stage::{BiasModel, Identifier};
//! use fd_ident::{arx::{ArxFit, ArxOrders, RecursiveArx}, rls::{RlsDesign, UdRls}};
//! use fd_model::{Channel, Record, SampleTime};
//!
//! // The bias of a model whose gain is a tenth too small: μ(k) = 0.9 μ(k−1) + 0.01 u(k).
//! let u: Vec<f64> = (0..500).map(|k| (f64::from(k) * 0.1).sin().signum()).collect();
//! let mu: Vec<f64> = u
//!     .iter()
//!     .scan(0.0, |mu, u| {
//!         *mu = 0.9 * *mu + 0.01 * u;
//!         Some(*mu)
//!     })
//!     .collect();
//! let (inputs, outputs) = (Channel::numbered("u", 1), Channel::numbered("mu", 1));
//! let record = Record::new(inputs, outputs, u, mu, SampleTime::new(0.1)?)?;
//! let orders = ArxOrders::new(1, 1, 0);
//!
//! // From the whole log ...
//! let fit = ArxFit::new(orders).fit(&[&record])?.model;
//! assert!((fit.theta()[0] + 0.9).abs() < 1e-9 && (fit.theta()[1] - 0.01).abs() < 1e-9);
//!
//! // ... or sample by sample ...
//! let kernel = UdRls::<f64>::new(orders.parameters(1), &RlsDesign::default())?;
//! let mut identifier = RecursiveArx::new(orders, 1, 1, kernel)?;
//! record.samples().for_each(|(u, mu)| identifier.update(u, mu));
//! // The prior variance of 1e6 pulls towards zero, by a millionth of the 500 samples.
//! assert!((identifier.theta()[0] + 0.9).abs() < 1e-3);
//!
//! // ... and then the bias is known from the input alone.
//! let mut bias = fit.freeze::<f32>()?;
//! let mut mu_hat = [0.0];
//! (0..200).for_each(|_| bias.simulate(&[1.0], &mut mu_hat));
//! assert!((mu_hat[0] - 0.1).abs() < 1e-5);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # When not to use it
//!
//! When a fault may be present in the training data: it would be learned as bias. When the cause
//! of the bias is known, model the cause instead.

mod columns;
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
#[cfg(feature = "testing")]
pub mod testing;

pub use crate::error::IdentError;
