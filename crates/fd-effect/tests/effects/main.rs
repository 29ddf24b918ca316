//! Effects: what the library promises of every candidate, their laws, and what they do not depend on.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::float_cmp,
    clippy::print_stdout,
    reason = "tests panic to fail, compare numbers that are exact, and report what they counted"
)]

mod alike;
mod cases;
mod convergence;
mod finer;
mod inside;
mod invariance;
mod laws;
mod library;
mod slopes;
mod text;
