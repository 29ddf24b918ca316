//! The command line in the process of Python.

use pyo3::prelude::*;

/// Runs the command line `fdiag`, the name of the program first, and returns its exit code.
#[pyfunction]
pub(crate) fn command(py: Python<'_>, arguments: Vec<String>) -> u8 {
    py.detach(|| fdiag_cli::run(arguments).0)
}
