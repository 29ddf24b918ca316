//! The command line in the process of Python.

use pyo3::prelude::*;

/// From now on nothing in this process starts a program or loads a library that a model file names.
#[pyfunction]
pub(crate) fn forbid_programs() {
    fdiag::forbid_programs();
}

/// From now on this command serves each instance of an FMU, with the FMU as one more argument.
#[pyfunction]
pub(crate) fn host_fmus(command: Vec<String>) {
    #[cfg(unix)]
    fdiag::sim::outside::host_fmus(command);
    #[cfg(not(unix))]
    drop(command);
}

/// Runs the command line `fdiag`, the name of the program first, and returns its exit code.
#[pyfunction]
pub(crate) fn command(py: Python<'_>, arguments: Vec<String>) -> u8 {
    py.detach(|| fdiag_cli::run(arguments).0)
}
