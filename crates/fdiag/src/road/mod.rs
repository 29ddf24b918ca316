//! The whole road: healthy logs in, a trained diagnosis out, and later logs through it.
//!
//! ```text
//! healthy logs ──generator──▶ r ──learning──▶ θ* ──┐
//!              └────────────▶ r ──compensation by θ*──▶ r* ──▶ threshold ──▶ Trained ──▶ pipeline for later logs
//! ```
//!
//! The engine benchmark and a user's own model and logs take the same road.

mod error;
mod learn;
mod residuals;
mod silent;
mod size;
mod trace;
mod train;

pub use self::{
    error::RoadError,
    residuals::residual_record,
    size::{sensor_signatures, sensor_sizes},
    trace::Trace,
    train::{Healthy, Trained, train},
};
