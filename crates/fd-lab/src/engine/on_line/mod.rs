//! The benchmark on line: recursive least squares from the first sample, the switch opened by the convergence
//! test, and what happens then.
//!
//! ```text
//! first sample ──learning──▶ open ──lead──▶ drift of the plant, or a fault, or nothing ──after──▶ end
//!                    └ a fault sets in half way
//! ```
//!
//! The input is that of a fresh run that goes on and on: steps and tones, the level where the last step left it. In
//! one case of its own fresh runs are joined as they are after the lead: the level then jumps further than in any run
//! that the threshold was set on. Only linear engines: their drift is
//! a way from one perturbed engine to another.

mod config;
mod plant;
mod report;
mod summary;
mod trial;

pub use self::{
    config::{OnLineConfig, TrainingFault},
    summary::{OnLineSummary, TrainingFaultSummary},
    trial::{Afterwards, Drift, InTraining, OnLine, Opened},
};
