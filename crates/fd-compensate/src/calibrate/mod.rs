//! Thresholds from fault-free data, for a stated false-alarm rate.
//!
//! Residuals are neither white nor Gaussian, so a threshold from a formula does not keep its stated rate. Here
//! the detector itself is run over the fault-free record and over **block-bootstrap** resamples of it: blocks
//! of consecutive samples are drawn with replacement from the record, closed into a circle (Politis & Romano
//! 1992), which keeps the distribution and, within a block, the correlation in time and across channels. Blocks
//! are at least five integrated autocorrelation times long.
//!
//! # What is promised
//!
//! * [`FalseAlarms::PerSample`]: the threshold is the `1 − rate` quantile of the statistic over the
//!   record.
//! * [`FalseAlarms::PerRun`]: the threshold is the `1 − probability` quantile of the largest statistic
//!   in resampled runs of the given length, each started with a reset detector. Where runs begin otherwise than they
//!   go on, [`calibrate_with_beginnings`] takes samples of that.
//!
//! Both come with an interval from recomputing the threshold on resampled records: how much it would
//! have differed with another record of the same length. Repeated alarms of one excursion are counted
//! as the debouncing counts them: the statistic that is calibrated is the `raise`-th largest of the
//! last `out_of`.
//!
//! A detector that has learned from the record fits it better than any other record, and a detector that
//! follows the input cannot be judged on blocks that are not consecutive; for both [`calibrate_held_out`]
//! judges whole stretches that the detector has not seen.
//!
//! # Assumptions, and when not to use it
//!
//! * The record is stationary, healthy, and long against its own memory; a record that is not ten
//!   blocks long is refused. It must cover the conditions that the threshold is meant for.
//! * Rates that the record cannot resolve (fewer than five independent exceedances expected) are refused,
//!   unless [`Beyond::Extrapolate`] asks for an exponential tail; the result then says so.
//! * Seams between blocks break the correlation. For detectors with a memory longer than a block (a
//!   cumulative sum with a small reference value) pass a longer block.

mod autocorrelation;
mod beginning;
mod bootstrap;
mod design;
mod error;
mod held_out;
mod statistics;
mod tail;

pub use self::{
    autocorrelation::autocorrelation_time,
    bootstrap::CircularBlocks,
    design::{
        Beyond, CalibratedThreshold, CalibrationPlan, FalseAlarms, calibrate,
        calibrate_with_beginnings,
    },
    error::CalibrationError,
    held_out::calibrate_held_out,
};
