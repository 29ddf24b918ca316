//! Numbers that come back from a user's function: whatever shape Python people give them.

use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::{prelude::*, types::PyFloat};

/// Why numbers cannot be taken.
pub(crate) enum Unfit {
    /// An exception of the conversion.
    Raised(PyErr),
    /// What was found instead.
    Found(String),
}

impl From<PyErr> for Unfit {
    fn from(error: PyErr) -> Self {
        Self::Raised(error)
    }
}

/// Writes `found` into `into`: a float for one number, an array of any shape with as many, or a sequence.
pub(crate) fn fill(found: &Bound<'_, PyAny>, into: &mut [f64]) -> Result<(), Unfit> {
    if let [one] = into
        && let Ok(number) = found.cast_exact::<PyFloat>()
    {
        *one = number.extract()?;
        return Ok(());
    }
    if let Ok(array) = found.cast::<PyArrayDyn<f64>>() {
        return copy(&array.try_readonly().map_err(|e| Unfit::Found(e.to_string()))?, into);
    }
    if found.is_none() {
        return Err(Unfit::Found("None: does it return its outputs?".to_owned()));
    }
    let array = found.py().import("numpy")?.call_method1("asarray", (found, "float64"));
    let array = array.map_err(|error| Unfit::Found(format!("{} ({error})", kind(found))))?;
    let array = array.cast_into::<PyArrayDyn<f64>>().map_err(PyErr::from)?;
    copy(&array.try_readonly().map_err(|e| Unfit::Found(e.to_string()))?, into)
}

fn copy(array: &PyReadonlyArrayDyn<'_, f64>, into: &mut [f64]) -> Result<(), Unfit> {
    if array.len() != into.len() {
        return Err(Unfit::Found(format!("an array of shape {:?}", array.shape())));
    }
    if let Ok(values) = array.as_slice() {
        into.copy_from_slice(values);
    } else {
        // In the order of rows, whatever the order in memory.
        for (to, from) in into.iter_mut().zip(array.as_array().iter()) {
            *to = *from;
        }
    }
    Ok(())
}

fn kind(found: &Bound<'_, PyAny>) -> String {
    let name = found.get_type().name();
    name.map_or_else(|_| "something else".to_owned(), |name| format!("a value of type `{name}`"))
}
