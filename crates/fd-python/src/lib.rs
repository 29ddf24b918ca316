//! The native half of the Python package `fdiag`: what runs in Rust, behind the plain Python of `python/fdiag`.
//!
//! | module | what it is for |
//! |---|---|
//! | `simulator` | a model text, or an object of Python, as what is diagnosed |
//! | `lender`, `instance` | how an object of Python is asked for runs |
//! | `study` | a gap study in threads of its own, which Ctrl-C stops |
//! | `check` | whether a simulator is fit for that |
//! | `settings`, `log` | what is asked, and arrays as logs |
//! | `online` | trained pipelines, a sample or an array at a time |
//! | `errors` | messages as exceptions |
//!
//! Nothing here is for users: names, units, doubts and pictures are made on the side of Python, and numbers in
//! the crates below. Threads of Rust run without the lock of the interpreter and take it for each call of a
//! user's object only.

#![allow(clippy::needless_pass_by_value, reason = "Python hands values over")]
#![allow(clippy::type_complexity, reason = "tuples are taken apart on the side of Python")]

mod check;
mod errors;
mod instance;
mod lender;
mod log;
mod online;
mod settings;
mod simulator;
mod study;
mod values;
mod watch;

use pyo3::prelude::*;

/// The native half of `fdiag`.
#[pymodule]
fn _fdiag(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<simulator::Simulator>()?;
    module.add_class::<study::Study>()?;
    module.add_class::<online::Trained>()?;
    module.add_class::<online::Pipeline>()?;
    module.add_function(wrap_pyfunction!(study::study, module)?)?;
    module.add_function(wrap_pyfunction!(check::check, module)?)?;
    module.add_function(wrap_pyfunction!(online::linear_channels, module)?)?;
    module.add_function(wrap_pyfunction!(settings::column_map, module)?)?;
    Ok(())
}
