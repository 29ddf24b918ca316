//! Is the log good enough for the question, and how much of it is noise?

mod agreement;
mod autoregression;
mod channel;
mod direct_path;
mod distribution;
mod feedback;
mod finding;
mod inputs;
mod inspect;
mod noise_floor;
mod pattern;
mod spectrum;
mod unresponsive;
mod wrapped;
mod wrong_sample;

pub use self::{
    autoregression::Autoregression,
    channel::grid_step,
    distribution::{
        HeavyTails, OutlierMixture, heavy_tails, interval_log_likelihood, outlier_mixture,
    },
    feedback::feedback,
    finding::{Defect, Finding, Severity},
    inspect::inspect,
    noise_floor::{noise_floor, robust_third_difference_floor, third_difference_floor},
    pattern::{Signal, pattern},
    spectrum::spectral_peaks,
    wrong_sample::{leave_out_wrong_samples, wrong_samples},
};
pub(crate) use self::{
    channel::COARSE_GRID,
    direct_path::passes_at_once,
    distribution::{MOST_OUTLIERS, OUTLIER_WIDTHS},
    noise_floor::{AT_THE_NOISE, EXPLAINED, REACHED},
    wrong_sample::{MOST_ACCIDENTS, NEIGHBOURS, neighbours, wrong_sample},
};
