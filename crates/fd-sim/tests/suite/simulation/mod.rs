//! Simulators: equations as text, models, black boxes in a shell, and what is spliced into them.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::float_cmp,
    clippy::print_stdout,
    reason = "tests panic to fail, compare numbers that are exact, and print what they saw"
)]

mod delays;
mod elementary;
mod equation;
mod linear;
mod models;
mod patch;
mod sensitivity;
mod sharing;
mod signs;
mod simulate;
mod stand_in;
