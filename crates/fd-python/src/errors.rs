//! Messages as exceptions: the classes are those of `python/fdiag/errors.py`.

use fd_gap::fit::FitError;
use fd_model::ShownMessage;
use fdiag::{core::Resource, gap_study::GapError, sim::outside::OutsideError};
use pyo3::prelude::*;

/// Which class an exception has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Class {
    /// A model, a log or a setting is missing or wrong.
    Input,
    /// The data or the model do not allow what was asked.
    Analysis,
    /// A simulator of the user has raised an exception, or does not do what it should.
    Simulator,
}

impl Class {
    fn name(self) -> &'static str {
        match self {
            Self::Input => "InputError",
            Self::Analysis => "AnalysisError",
            Self::Simulator => "SimulatorError",
        }
    }
}

/// An exception with a message that a terminal shows and does not obey.
pub(crate) fn raise(py: Python<'_>, class: Class, message: &str) -> PyErr {
    let made = || -> PyResult<PyErr> {
        let kind = py.import("fdiag.errors")?.getattr(class.name())?;
        Ok(PyErr::from_value(kind.call1((ShownMessage(message).to_string(),))?))
    };
    made().unwrap_or_else(|error| error)
}

/// The exception of an input that is wrong.
pub(crate) fn input(py: Python<'_>, error: &impl ToString) -> PyErr {
    raise(py, Class::Input, &error.to_string())
}

/// The exception of an analysis that is not possible.
pub(crate) fn analysis(py: Python<'_>, error: &impl ToString) -> PyErr {
    raise(py, Class::Analysis, &error.to_string())
}

/// What cannot be simulated or fitted is no mistake of a file; as the exit codes of the command line.
pub(crate) fn class(error: &GapError) -> Class {
    match error {
        GapError::Limit(limit) if limit.resource != Resource::Bytes => Class::Analysis,
        GapError::Budget { .. } | GapError::Simulate(_) | GapError::Fit(_) => Class::Analysis,
        GapError::Unfit { source, .. } if matches!(**source, FitError::TooShort { .. }) => {
            Class::Analysis
        }
        GapError::Simulator(error) if matches!(**error, OutsideError::Forbidden { .. }) => {
            Class::Input
        }
        GapError::Simulator(_) | GapError::Outside { .. } => Class::Simulator,
        _ => Class::Input,
    }
}
