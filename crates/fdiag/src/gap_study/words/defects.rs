//! What is wrong with logs, and what was done with their time bases.

use fd_model::figure;

use super::numbers::four;
use crate::gap_study::{
    log_finding::{LogDefect, SimulatorDefect, TimeBaseDefect},
    log_part::Pace,
};

/// What was found, without file and channel.
#[must_use]
pub fn defect(defect: &LogDefect) -> String {
    match defect {
        LogDefect::Channel(defect) => defect.to_string(),
        LogDefect::TimeBase(TimeBaseDefect::Holes { count }) => {
            format!("{count} holes are too long to be bridged")
        }
        LogDefect::TimeBase(TimeBaseDefect::Uneven { median_step_s, jitter_s, step_s }) => format!(
            "rows are {} s apart (jitter {} s): resampled to {} s",
            four(*median_step_s),
            four(*jitter_s),
            four(*step_s)
        ),
        LogDefect::TimeBase(TimeBaseDefect::Coarse { median_step_s, step_s }) => format!(
            "rows are {} s apart, but simulated and compared every {} s: an input that moves in between acts on the \
             simulation as its mean, which can look like friction, a delay or a periodic force; without resampling it \
             acts as logged",
            four(*median_step_s),
            four(*step_s)
        ),
        LogDefect::TimeBase(TimeBaseDefect::Pace { log_s, model_s }) => format!(
            "samples are {} s apart, the model says {} s: it is simulated at the pace of the log",
            four(*log_s),
            four(*model_s)
        ),
        LogDefect::TimeBase(TimeBaseDefect::Clock) => {
            "the effect depends on the time since the start of a run, and held-out logs have a \
             start of their own: what it does there may not carry over"
                .to_owned()
        }
        LogDefect::Simulator(SimulatorDefect::NotRepeatable { spread, unit, runs }) => {
            let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
            let spread = figure(*spread);
            format!(
                "the simulator does not repeat itself: this output differs by {spread}{unit} between equal runs \
                 ({runs} were made), which counts as noise"
            )
        }
    }
}

/// What was done with uneven and missing samples.
#[must_use]
pub fn time_policy(pace: Pace) -> String {
    let pace = match pace {
        Pace::Stated => "as stated",
        Pace::Model => "at the pace of the model, which is sampled itself",
        Pace::FirstLog => "at the median pace of the first log",
    };
    format!(
        "Logs are on an even time base {pace}: inputs keep their last value, outputs are \
         interpolated over short holes; outputs that are missing are not compared."
    )
}
