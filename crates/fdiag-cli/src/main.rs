//! The `fdiag` command line: arguments in, tables, reports and an exit code out.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command-line tool")]

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::run()
}
