//! Extended least squares for ARMAX models, `A(q) μ = B(q) u + C(q) e`.
//!
//! Past prediction errors stand in the regressor for the noise that cannot be measured,
//!
//! ```text
//! φ(k) = [−μ(k−1) …; u(k−d) …; 1; ε(k−1) … ε(k−nc)],      θ = [a; b; c₀; c₁ … c_nc]
//! ```
//!
//! which makes a linear problem whose regressor depends on its own solution: a *pseudo-linear
//! regression*. Source: Ljung (1999), eq. (10.59) to (10.64); Ljung & Söderström (1983),
//! section 3.7.3 (recursive, with a posteriori errors, "AML").
//!
//! | | type |
//! |---|---|
//! | all records at once, iterated | [`ExtendedLeastSquares`] |
//! | sample by sample, any [`RlsKernel`](crate::rls::RlsKernel) | [`RecursiveArmax`] |
//!
//! Only `a`, `b` and the constant are the bias model; `c` keeps the noise out of them. White
//! measurement noise on `μ` is the case `C = A`, so `nc = na` makes least squares unbiased for it.
//! [`PredictionError`](crate::prediction_error::PredictionError) refines the result to least
//! variance.
//!
//! # When not to use it
//!
//! When `Re 1/C(e^{jω}) > ½` does not hold at all frequencies, convergence is not certain
//! (Ljung & Söderström 1983, theorem 4.6); slow poles with measurement noise, `C = A` with roots
//! near 1, are such a case: use SRIV or output error there. Without noise the past errors are
//! zero and the regressor loses rank; use plain least squares.

mod batch;
mod recursive;

pub use self::{
    batch::{ExtendedEstimate, ExtendedLeastSquares},
    recursive::RecursiveArmax,
};
