//! Is anything left to be learned in the residuals of a fitted model?
//!
//! | test | hypothesis | source |
//! |---|---|---|
//! | [`whiteness`] | one-step errors are white | Ljung & Box (1978), `Q = N(N+2) Σ r²(τ)/(N−τ)` |
//! | [`independence`] | one-step errors do not depend on past inputs | Ljung (1999), section 16.6, all lags together by Bonferroni |
//!
//! Both take several stretches of data with NaN for missing samples; only pairs that are both
//! there count, and none reaches across stretches.
//!
//! # When not to use them
//!
//! On noise-free data: the one-step errors are then unmodelled dynamics, never white, and the
//! tests only say that. Judge such models by their held-out simulation error.

mod correlation;
mod hypotheses;

pub use self::{
    correlation::{Stretch, autocorrelation},
    hypotheses::{Independence, Whiteness, independence, whiteness},
};
