//! Every parser, given inputs that are nearly right: none may panic, hang or take the machine.
//!
//! Each test tries 2000 inputs, always the same; `FDIAG_FUZZ_SECONDS` and `FDIAG_FUZZ_SEED` make it a search. An input
//! is changed at random from a seed or from an earlier input of which something new became. What was found is kept in
//! the folder `found` as `TARGET-WHAT`, and is a seed ever after; so are the inputs in `corpus`, which were found by the
//! engine in `fuzz/` that is guided by coverage.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]
#![allow(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "how many inputs were tried, and which failed"
)]
#![allow(unreachable_pub, reason = "modules of one test binary")]

mod engine;
mod mutate;
mod targets;
