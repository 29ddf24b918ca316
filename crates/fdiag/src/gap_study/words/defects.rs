//! What is wrong with logs, and what was done with their time bases.

use super::numbers::four;
use crate::gap_study::{
    findings::{LogDefect, TimeBaseDefect},
    report::Pace,
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
