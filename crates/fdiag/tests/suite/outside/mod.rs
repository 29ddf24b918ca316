//! Simulators outside of this program, diagnosed from logs to report.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::print_stdout, reason = "a test")]

mod cart;
mod unrepeatable;
