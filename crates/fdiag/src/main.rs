//! The `fdiag` command line: arguments in, tables, reports and an exit code out.
fn main() {}
