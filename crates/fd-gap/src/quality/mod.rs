//! Is the log good enough for the question, and how much of it is noise?

mod autoregression;
mod channel;
mod distribution;
mod finding;
mod inputs;
mod inspect;
mod noise_floor;
mod pattern;
mod spectrum;

pub use self::{
    autoregression::Autoregression,
    channel::grid_step,
    distribution::{
        HeavyTails, OutlierMixture, heavy_tails, interval_log_likelihood, outlier_mixture,
    },
    finding::{Defect, Finding, Severity},
    inspect::inspect,
    noise_floor::{noise_floor, robust_third_difference_floor, third_difference_floor},
    pattern::{Signal, pattern},
    spectrum::spectral_peaks,
};
pub(crate) use self::{distribution::OUTLIER_WIDTHS, spectrum::transform};
