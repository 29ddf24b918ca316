//! The performance of a detector, measured on recorded statistics.
//!
//! Plain functions on slices for benchmarks and reports: how often it alarms without a fault, how long a fault
//! stays undetected, and which fault is the smallest that is detected. Comparisons between methods are fair
//! only at equal false-alarm rates: calibrate each threshold first.

mod alarms;
mod run_length;
mod smallest;

pub use self::{
    alarms::{DebouncedStatistic, alarms, debounced_statistics, detection_delay, false_alarm_rate},
    run_length::{RunLength, run_length},
    smallest::{smallest_detectable, smallest_detectable_by_search},
};
