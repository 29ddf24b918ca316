//! How far a gap shrinks on data that the fit has not seen.
//!
//! Everything is a forecast: the initial state of a window comes from its first half (of a free run, from its
//! first quarter), and only the rest is scored. The gap before is that of the model with refitted parameters,
//! which is the honest comparison, and also that of the nominal model. What belongs to one run, such as the phase of
//! a periodic force, is another one in a log with a clock of its own ([`Paths`]).

mod another_run;
mod baselines;
mod begun;
mod carried;
mod contest;
mod forecast;
mod gap;
mod horizons;

pub use self::{
    another_run::Paths,
    baselines::Baselines,
    contest::{Contest, Forecasts, Rules},
    forecast::{Settled, forecast_errors},
    gap::{Closed, Errors, closed, gap, gap_per_output},
    horizons::{dominant_time_constant, horizons},
};
pub(crate) use self::{begun::as_begun, forecast::errors_from_best_starts};
