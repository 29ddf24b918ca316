//! The benchmark plant: a nonlinear 17-state two-spool turbofan and published linear engines.

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
