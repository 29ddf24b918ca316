//! Linear models: designed with faer in `f64`, run with any [`Scalar`](fd_core::Scalar).
//!
//! | Side | Type | Numbers | Sizes |
//! |------|------|---------|-------|
//! | design | [`StateSpace`] | `f64`, faer | run time |
//! | run | [`Lti`] | any scalar, nalgebra | compile time or run time |
//!
//! [`StateSpace::freeze`] is the only way from the first row to the second.

mod channel;
mod discretize;
mod domain;
mod error;
mod figure;
mod freeze;
mod lti;
mod record;
mod state_space;

// Numerics of linear models.
mod connect;
mod frequency;
mod gramian;
mod hankel;
mod linalg;
pub mod lyapunov;
mod norms;
pub mod reduce;
pub mod riccati;
pub mod uncertainty;
mod zeros;

pub use crate::norms::PeakGain;

// Signals, faults, records and files.
mod clock;
pub mod fault;
pub mod file;
mod inputs;
mod resample;
pub mod signal;
mod simulate;
pub mod unit;

pub use crate::{
    channel::Channel,
    domain::{Continuous, Discrete, SampleTime, TimeDomain},
    error::ModelError,
    figure::figure,
    freeze::freeze,
    lti::Lti,
    record::Record,
    state_space::StateSpace,
};
pub use crate::{
    inputs::Inputs,
    record::{ChannelScale, MissingCounts, RecordError, Scaling},
    resample::{Disorder, Gap, ResamplePolicy, TimeBaseError, TimeBaseReport, TimeSeries},
    simulate::{Simulation, SimulationError},
};
