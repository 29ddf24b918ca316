//! The `fdiag` command line: arguments in, tables, reports and an exit code out.

use fd_console::failure::ExitCode;

fn main() -> ExitCode {
    fdiag_cli::run(std::env::args_os())
}
