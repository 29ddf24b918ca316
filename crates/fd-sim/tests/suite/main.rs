//! The integration tests of `fd-sim`, one program.

#[cfg(feature = "fmu")]
mod fmu;
mod outside;
mod simulation;
