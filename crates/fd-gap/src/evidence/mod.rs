//! How strongly a log speaks for a cause.
//!
//! Evidence is the probability of the log under a model, averaged over its unknown parameters ([`evidence`], by
//! Laplace's method at the fit). *When not to use:* with white weights when even the best model ends far above the
//! noise, as on most real logs: likelihoods are unrealistically sharp there. What is unknown must be in the weights then
//! ([`Unknown`](crate::fit::Unknown)).

mod laplace;
mod likelihood;
mod posterior;
mod tie;

pub(crate) use self::likelihood::{likelihood_at, of_rounding};
pub use self::{
    laplace::{DECADES, evidence},
    likelihood::{Likelihood, NoisePrior, likelihood},
    posterior::{pool, probabilities},
    tie::{SEPARATED, distance},
};
