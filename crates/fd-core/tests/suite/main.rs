//! The integration tests of `fd-core`, one program.

mod altered;
mod boxes;
mod contracts;
mod fitting;
mod flow;
mod limits;
mod pipeline;
mod smallest;
