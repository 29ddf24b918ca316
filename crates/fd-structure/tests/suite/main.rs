//! The integration tests of `fd-structure`, one program.

mod choices;
mod generators;
mod laws;
mod structures;
mod toolbox;
