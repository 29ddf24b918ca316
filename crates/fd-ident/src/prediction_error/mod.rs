//! Prediction-error estimates: output-error, Box-Jenkins and ARMAX models by Gauss-Newton.
//!
//! ```text
//! μ(k) = B(q)/A(q) u(k) + C(q)/D(q) e(k),      e white;      θ̂ = argmin Σ ε²(k, θ)
//! ```
//!
//! | structure | noise | [`NoiseStructure`] |
//! |---|---|---|
//! | output error | `C = D = 1`: white measurement noise | `OutputError` |
//! | Box-Jenkins | `C`, `D` of their own: coloured measurement noise | `BoxJenkins` |
//! | ARMAX | `D = A`: noise goes through the dynamics of the plant | `Armax` |
//!
//! Source: Ljung (1999), *System identification*, eq. (4.31) for the family, (10.40) to (10.46)
//! for the damped Gauss-Newton search, (9.55) for the covariance. Patton & Chen (1992) leave
//! "the stochastic case ... noise modelling" as further study; this is the noise modelling.
//!
//! * The simulation of `μ̂` never uses `C` and `D`, so every structure ends in an
//!   [`ArxModel`](crate::arx::ArxModel). Noise only decides how its parameters are found.
//! * Gradients are computed by running the sensitivities of the predictor along with it, so a
//!   missing sample is treated exactly as the predictor treats it: `ε = 0`, and the noise goes on
//!   by its own prediction. Missing inputs are held.
//! * Roots of `A`, `C` and `D` outside the unit circle are reflected before a step is judged, and a step is
//!   taken only if it reduces the cost.
//! * The search starts from least squares and from SRIV (or from pseudo-linear regression for ARMAX), and the
//!   best result is kept.
//!
//! # When not to use it
//!
//! When the model is of lower order than the bias and there is hardly any noise: all structures
//! then fit the error of approximation, output error being the one that fits what is simulated.
//! Box-Jenkins with white noise has a common factor in `C/D` that nothing determines; `A` and
//! `B` do not suffer, standard errors of `c` and `d` do. The covariance assumes that the noise
//! structure is right: output error in coloured noise is unbiased, but its errors are understated.

mod bordered;
mod fit;
mod gauss_newton;
mod predictor;
mod problem;
mod start;
#[cfg(test)]
mod tests;

pub use self::{
    fit::{ChannelFit, NoiseModel, PredictionError, PredictionErrorEstimate},
    predictor::NoiseStructure,
};
