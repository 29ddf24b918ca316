//! The integration tests of `fd-core`, one program.

mod altered;
mod boxes;
mod contracts;
mod fitting;
mod limits;
mod opening;
mod pipeline;
mod smallest;
mod void;
