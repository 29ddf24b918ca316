//! The jet engine as a subject of gap diagnosis, with effects of its own.
//!
//! [`EngineSimulator`] is the nonlinear engine with its health exposed as parameters, to be wrapped
//! in a [`Shell`](fd_gap::simulate::Shell); [`linear_engine`] is its linearisation as equations;
//! [`EngineFile`] is either of them as a model file.
//! [`engine_effects`] are what engines suffer from. [`engine_log`] makes logs of an engine that has
//! one of them, by another integration than that of the simulators.
//!
//! *What is not independent:* the engine of the logs and that of the nonlinear simulator share the
//! equations of the gas path; only step, scatter, noise and the withheld cause differ.

mod effects;
mod error;
mod file;
mod linear;
mod reality;
mod simulator;
mod study;

pub(super) use self::file::ENGINE_KIND;
pub use self::{
    effects::{
        BLEED_LEAK, COMBUSTION, EngineEffect, FLOW_CAPACITY, HEAT_SOAK, MODULE_EFFICIENCY,
        NOZZLE_AREA, engine_effects,
    },
    error::EnginePlantError,
    file::{EngineFile, EngineFileError},
    linear::linear_engine,
    reality::{EngineCause, RELATIVE_NOISE, engine_log, engine_noise},
    simulator::{EngineKnowledge, EngineSimulator, METAL_CONDUCTANCE},
    study::{Answer, diagnose_engine, nonlinear_engine, simulator},
};
