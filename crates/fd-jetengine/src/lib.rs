//! The benchmark plant: a nonlinear 17-state two-spool turbofan and published linear engines.

pub mod engine17;
mod error;
mod model;

pub use crate::{
    error::{Compressor, EngineError},
    model::{EngineModel, OperatingPoint, Scaling},
};
