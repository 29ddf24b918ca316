//! The jet engine as a simulator of a gap diagnosis, with effects of its own.
//!
//! [`EngineSimulator`] is the nonlinear engine with its health exposed as parameters, to be wrapped
//! in a [`Shell`](fd_sim::simulate::Shell); [`linear_engine`] is its linearisation as equations;
//! [`EngineFile`] is either of them as a model file.
//! [`engine_effects`] are what engines suffer from.

mod effects;
mod error;
mod file;
mod linear;
mod noise;
mod nominal;
mod simulator;
mod state_equations;

pub(crate) use self::state_equations::EngineEquations;
pub use self::{
    effects::{
        BLEED_LEAK, COMBUSTION, EngineEffect, FLOW_CAPACITY, HEAT_SOAK, MODULE_EFFICIENCY,
        NOZZLE_AREA, engine_effects,
    },
    error::EnginePlantError,
    file::{ENGINE_KIND, EngineFile, EngineFileError},
    linear::linear_engine,
    noise::{RELATIVE_NOISE, engine_noise},
    nominal::{nonlinear_engine, simulator},
    simulator::{EngineKnowledge, EngineSimulator, METAL_CONDUCTANCE},
};
