//! Linear models: designed in `f64` with faer, run with any [`Scalar`](fd_core::Scalar).
//!
//! | Side | Type | Numbers | Sizes |
//! |------|------|---------|-------|
//! | design | [`StateSpace`] | `f64`, faer | run time |
//! | run | [`Lti`] | any scalar, nalgebra | compile time or run time |
//!
//! [`StateSpace::freeze`] is the only way from the first row to the second.
//!
//! From equations to a log with a fault in it:
//!
//! ```
//! use faer::mat;
//! use fd_core::Heap;
//! use fd_model::{
//!     Channel, Continuous, Inputs, SampleTime, Simulation, StateSpace,
//!     fault::{FaultProfile, FaultSpec, Site},
//!     signal::Step,
//! };
//!
//! // Two tanks in a row; the level of the second one is measured.
//! let (a, b) = (mat![[-0.5, 0.0], [0.5, -0.2]], mat![[1.0], [0.0]]);
//! let tanks = StateSpace::new(a, b, mat![[0.0, 1.0]], mat![[0.0]], Continuous)?;
//! assert!(tanks.is_stable()?);
//! assert!((tanks.dc_gain()?[(0, 0)] - 5.0).abs() < 1e-12);
//!
//! // Design in continuous time and f64, run sampled.
//! let ts = SampleTime::new(0.5)?;
//! let plant = tanks.sample_zoh(ts)?.freeze::<f64, Heap>()?;
//! let inputs = Inputs::from_signals([(Channel::new("inflow", "l/s"), Step::new(1.0, 0.0))], 200, ts)?;
//! let fault = FaultSpec::add(Site::sensor("level"), 90.0, FaultProfile::abrupt(0.3));
//! let run = Simulation { faults: vec![fault], ..Simulation::default() };
//! let log = run.run(&plant, &inputs, vec![Channel::new("level", "m")])?;
//!
//! // e^(−0.2 · 85) = 4e-8 of the transient is left at 85 s, and the fault begins at 90 s.
//! let level: Vec<f64> = log.output(0).collect();
//! assert!((level[170] - 5.0).abs() < 1e-6 && (level[190] - 5.3).abs() < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod channel;
mod circle;
mod discretize;
mod domain;
mod error;
mod figure;
mod freeze;
mod lti;
mod record;
mod state_space;

// Numerics of linear models.
mod channels;
mod connect;
mod descriptor;
mod frequency;
mod gramian;
mod hankel;
mod linalg;
pub mod lyapunov;
mod natural_units;
mod norms;
pub mod reduce;
pub mod riccati;
mod transfer;
pub mod uncertainty;
mod zeros;

/// The matrices of designs, so that those who use this library need not name the version of faer.
pub use faer;

pub use crate::{
    descriptor::DescriptorSystem, natural_units::NaturalUnits, norms::PeakGain,
    transfer::TransferFunction,
};

// Signals, faults, records and files.
mod clock;
pub mod fault;
pub mod file;
mod inputs;
mod nearest;
mod resample;
mod shown;
pub mod signal;
mod simulate;
pub mod unit;

pub use crate::{
    channel::Channel,
    circle::Circle,
    domain::{Continuous, Discrete, SampleTime, TimeDomain},
    error::ModelError,
    figure::{duration, figure},
    freeze::freeze,
    lti::Lti,
    record::Record,
    state_space::StateSpace,
};
pub use crate::{
    inputs::Inputs,
    nearest::nearest,
    record::{ChannelScale, MissingCounts, RecordError, Scaling},
    resample::{
        Disorder, Gap, HeldInputs, ResamplePolicy, TimeBaseError, TimeBaseReport, TimeSeries,
    },
    shown::{Shown, ShownList, ShownMessage, is_plain},
    simulate::{Simulation, SimulationError},
};
