//! The integration tests of `fd-watch`, one program.

#[path = "../../../fdiag/tests/suite/support/mod.rs"]
mod support;

mod alarms;
mod ask;
mod common;
mod input;
mod kept;
mod monitor;
mod state;
