//! The integration tests of `fdiag`, one program.

mod bias_kinds;
mod data_driven;
mod detector_kinds;
mod docs;
mod fleet;
mod generators;
mod limits;
mod motor;
mod no_alloc;
mod nonlinear;
mod outside;
mod pipeline_laws;
mod start_in_training;
mod stated_rates;
mod static_and_spec;
mod support;
