//! The `fdiag` command line: arguments in, tables, reports and an exit code out.

use fd_console::failure::ExitCode;
use fdiag::sim::outside::host_fmus;

fn main() -> ExitCode {
    // Each instance of an FMU is another process of this program.
    if let Some(own) = std::env::current_exe().ok().as_deref().and_then(std::path::Path::to_str) {
        host_fmus([own, "simulator", "serve"]);
    }
    fdiag_cli::run(std::env::args_os())
}
