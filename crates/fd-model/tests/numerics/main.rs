//! Numerics of linear models: published numbers, algebra and edge cases.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
#![allow(clippy::print_stdout, reason = "says what is skipped and how accurate the rest is")]

mod descriptor;
mod edges;
mod engines;
mod lyapunov;
mod models;
mod natural_units;
mod norms;
mod oracle;
mod reduction;
mod riccati;
mod sampling;
mod uncertainty;
