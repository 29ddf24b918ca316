//! A separate program as a simulator, over its standard input and output.
//!
//! Each direction begins with a line of JSON, the *hello*: what the file says about the simulator, and what the
//! simulator says about itself. Then binary frames go back and forth. `docs/process-protocol.md` describes
//! both.
//!
//! *When not to use:* on systems other than Unix, where waiting for a pipe with a timeout needs other means; a
//! process is refused there.

mod child;
mod frame;
mod hello;
mod instance;
mod note;
mod program;
mod serve;
#[cfg(feature = "fmu")]
mod streams;

pub use self::{
    frame::PROTOCOL_VERSION,
    program::Process,
    serve::{serve, stated},
};
#[cfg(feature = "fmu")]
pub(super) use self::{
    note::{tell, tell_in_case_of_an_end},
    serve::{Widths, answer, greet, heard},
    streams::own_streams,
};
