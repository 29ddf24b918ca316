//! The benchmark plant: a nonlinear 17-state two-spool turbofan and published linear engines.
//!
//! | engine | states, inputs, outputs | here |
//! |--------|-------------------------|------|
//! | engine17, nonlinear | 17, 1, 5 | [`engine17::Engine17`], stepped as [`engine17::Sampled`] |
//! | engine17 with unmodelled dynamics | 23, 1, 5 | [`engine17::ExtendedEngine`] |
//! | engine17, linearised anywhere | 17, 1, 5 | [`engine17::Engine17::linearise`] |
//! | F100, linear | 16, 3, 5 | [`f100()`] |
//! | Chen, Patton & Zhang (1996) | 3, 1, 6 | [`chen_patton_zhang()`], with its quadratic term [`ChenPattonZhang`] |
//!
//! Linear engines share one type, [`EngineModel`], so code that accepts one accepts all. Scale it
//! ([`EngineModel::per_unit`], [`EngineModel::equilibrated`]) before reducing it or designing an observer, and
//! use [`Perturbation`] to make an engine that differs from its model.
//!
//! ```
//! use fd_jetengine::{Perturbation, engine17::{Engine17, Parameters, PowerSetting}};
//!
//! let engine = Engine17::new(&Parameters::default())?;
//! let fuel = PowerSetting::Reference.fuel();
//! let model = engine.linearise(&engine.trim(fuel)?)?.per_unit()?;
//! let plant = Perturbation::default().draw_engine17(&engine, fuel, 1)?;
//! assert_eq!(model.outputs[2].to_string(), "T_7 [1]");
//! assert_eq!(plant.model.outputs, model.outputs);
//! # Ok::<(), fd_jetengine::EngineError>(())
//! ```

pub mod engine17;
mod error;
mod linear;
mod model;
mod perturbation;
mod runge_kutta;

pub use crate::{
    error::{Compressor, EngineError},
    linear::{ChenPattonZhang, chen_patton_zhang, f100},
    model::{EngineModel, OperatingPoint, Scaling},
    perturbation::{Perturbation, PerturbedEngine},
};
