//! The `fdiag` command line.
fn main() {}
