//! Is the log good enough for the question, and how much of it is noise?

mod autoregression;
mod channel;
mod finding;
mod inspect;
mod noise_floor;
mod spectrum;

pub use self::{
    autoregression::Autoregression,
    channel::grid_step,
    finding::{Defect, Finding, Severity},
    inspect::inspect,
    noise_floor::{noise_floor, robust_third_difference_floor, third_difference_floor},
    spectrum::spectral_peaks,
};
