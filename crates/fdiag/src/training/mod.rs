//! Training: from healthy logs to a trained diagnosis, and later logs through it.
//!
//! ```text
//! healthy logs ──generator──▶ r ──learning──▶ θ* ──┐
//!              └────────────▶ r ──compensation by θ*──▶ r* ──▶ threshold ──▶ Trained ──▶ pipeline for later logs
//! ```
//!
//! The engine benchmark and a user's own model and logs are trained the same way.

mod begin;
mod bias;
mod calibration;
mod choose;
mod error;
mod examine;
mod fault_free;
mod fit;
mod healthy;
mod learn;
mod pay;
mod replay;
mod residuals;
mod running;
mod silent;
mod size;
mod structure;
mod trace;
mod train;
mod trained;

pub use self::{
    begin::settling_time,
    bias::LearnedBias,
    choose::Compared,
    error::TrainingError,
    examine::{Doubt, Examination, Names, examine, inputs_move},
    healthy::Healthy,
    pay::{Applied, Payment, WhyNot},
    replay::{Primary, Subtracted, Subtraction},
    residuals::residual_record,
    running::RunningBias,
    size::{sensor_signatures, sensor_sizes},
    trace::{LONGEST_GAP, Trace},
    train::{train, train_on, train_within},
    trained::Trained,
};
