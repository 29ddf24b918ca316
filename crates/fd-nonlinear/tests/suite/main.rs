//! The integration tests of `fd-nonlinear`, one program.

mod allocation;
mod common;
mod growth;
mod laws;
mod linear;
mod patched;
mod whiteness;
