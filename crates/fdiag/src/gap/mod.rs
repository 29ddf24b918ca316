//! Diagnosis of the sim-to-real gap.

pub mod engine_plant;
