//! The integration tests of `fd-jetengine`, one program.

mod common;
mod golden;
mod linear_engines;
mod linearisation;
mod physics;
mod reductions;
