//! Diagnosis of the sim-to-real gap.

pub mod equation;
pub mod model;
