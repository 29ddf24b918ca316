//! The integration tests of `fd-structure`, one program.

mod choices;
mod generators;
mod laws;
mod published;
mod structures;
mod toolbox;
