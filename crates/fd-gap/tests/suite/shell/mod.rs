//! Shells: what is diagnosed when a simulator only steps.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::float_cmp,
    clippy::print_stdout,
    reason = "tests panic to fail, compare numbers that are exact, and print what they saw"
)]

mod allocation;
mod diagnosis;
mod few_runs;
mod hidden;
mod laws;
mod natives;
mod pendulum;
