//! The integration tests of `fd-residual`, one program.

mod allocation;
mod common;
mod decoupling;
mod isolation;
mod laws;
mod matching;
mod model_detection;
mod parity;
mod placement;
mod published;
mod published_designs;
mod published_noise;
mod published_observers;
mod published_signatures;
mod ranks;
mod several_models;
mod zonotope;
