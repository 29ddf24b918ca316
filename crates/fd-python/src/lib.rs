//! The native half of the Python package `fdiag`: what runs in Rust, behind the plain Python of `python/fdiag`.
//!
//! | module | what it is for |
//! |---|---|
//! | `simulator` | a model text, or a Python object, as the simulator to diagnose |
//! | `lender`, `instance` | how runs are requested from a Python object |
//! | `scene` | how samples of a `MuJoCo` scene are taken |
//! | `remote`, `hosted` | how runs are requested from another process, and what answers there |
//! | `study` | a gap study in its own threads, which Ctrl-C stops |
//! | `check` | whether a simulator is fit for a gap study |
//! | `settings`, `log` | settings, and arrays as logs |
//! | `online` | trained pipelines, a sample or an array at a time |
//! | `command` | the command line `fdiag`, in the process of Python |
//! | `errors` | messages as exceptions |
//!
//! What a user writes, and what of it ends up here (`simulator`, `study`):
//!
//! ```python
//! import fdiag
//!
//! result = fdiag.gap(fdiag.Model("cart.toml"), "monday.csv", held_out="friday.csv")
//! print(result.headline)
//! ```
//!
//! Nothing here is for users directly: names, units, doubts and pictures are made in Python, and numbers in the
//! crates below. Rust threads run without the interpreter lock and take it only for each call of a user's
//! object.

#![allow(clippy::needless_pass_by_value, reason = "Python hands values over")]
#![allow(clippy::type_complexity, reason = "tuples are taken apart on the side of Python")]

mod calibrate;
mod check;
mod command;
mod errors;
mod hosted;
mod instance;
mod lender;
mod log;
mod online;
mod remote;
mod scene;
mod settings;
mod simulator;
mod stacked;
mod study;
mod troubles;
mod values;
mod watch;

use pyo3::prelude::*;

/// The native half of `fdiag`.
#[pymodule]
fn _fdiag(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<simulator::Simulator>()?;
    module.add_class::<scene::SceneSteps>()?;
    module.add_class::<hosted::Hosted>()?;
    module.add_class::<study::Study>()?;
    module.add_class::<online::Trained>()?;
    module.add_class::<online::Pipeline>()?;
    module.add_function(wrap_pyfunction!(study::study, module)?)?;
    module.add_function(wrap_pyfunction!(calibrate::calibrate, module)?)?;
    module.add_function(wrap_pyfunction!(check::check, module)?)?;
    module.add_function(wrap_pyfunction!(command::command, module)?)?;
    module.add_function(wrap_pyfunction!(command::forbid_programs, module)?)?;
    module.add_function(wrap_pyfunction!(command::host_fmus, module)?)?;
    module.add_function(wrap_pyfunction!(online::linear_channels, module)?)?;
    module.add_function(wrap_pyfunction!(settings::column_map, module)?)?;
    Ok(())
}
