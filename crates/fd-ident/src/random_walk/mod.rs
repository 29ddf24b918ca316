//! Recursive least squares as a Kalman filter for parameters that follow a random walk.
//!
//! ```text
//! θ(k) = θ(k−1) + w(k),  cov w = Q        M = P + Q
//! μ(k) = φᵀ(k) θ(k) + e(k),  var e = 1    K = M φ / (1 + φᵀ M φ),  P = M − K φᵀ M
//! ```
//!
//! Source: Ljung (1999), eq. (11.29), with the factorisation of Bierman (1977). Variances are
//! relative to that of the noise, as everywhere in [`rls`](crate::rls). [`KalmanRls`] is an
//! [`RlsKernel`](crate::rls::RlsKernel), so
//! [`RecursiveArx`](crate::arx::RecursiveArx) and
//! [`RecursiveArmax`](crate::extended::RecursiveArmax) make an
//! [`Identifier`](fd_core::stage::Identifier) of it.
//!
//! Unlike a forgetting factor, `Q` says *which* parameters move and how fast, and information is
//! lost per sample, not per sample of excitation in proportion to what is known. With
//! `Q = (1/λ − 1) P` it is exponential forgetting with `λ`, with `Q = 0` ordinary least squares.
//!
//! # When not to use it
//!
//! When nothing is known about how parameters move: directional forgetting needs one number and
//! cannot wind up. Here the covariance of unexcited directions grows by `Q` per sample; the guard
//! stops that at a multiple of the prior.

mod run;

pub use self::run::{Drift, KalmanRls, RandomWalkDesign};
