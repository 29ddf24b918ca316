//! The integration tests of `fd-data`, one program.

mod allocation;
mod common;
mod golden;
mod laws;
mod numbers;
