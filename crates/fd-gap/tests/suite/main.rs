//! The integration tests of `fd-gap`, one program.

mod constants;
mod diagnosis;
mod estimate;
mod shell;
