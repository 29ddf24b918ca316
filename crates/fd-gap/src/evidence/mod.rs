//! How strongly a log speaks for a cause.
//!
//! Evidence is the probability of the log under a model, averaged over its unknown parameters ([`evidence`], by
//! Laplace's method at the fit). It is for logs that the best model explains down to the noise. *When not to
//! use:* when even the best model ends far above the noise, as on most real logs, likelihoods are
//! unrealistically sharp; then forecasts must decide ([`win_frequencies`]).

mod frequency;
pub(crate) mod grades;
mod laplace;
mod likelihood;
mod posterior;
mod tie;

pub(crate) use self::likelihood::{best_log_scale, of_rounding};
pub use self::{
    frequency::{BlockErrors, win_frequencies, win_frequencies_over},
    laplace::{DECADES, evidence},
    likelihood::{Likelihood, NoisePrior, likelihood},
    posterior::{pool, probabilities},
    tie::{SEPARATED, distance},
};
