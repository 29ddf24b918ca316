//! Which residual is to react to which fault.

use fd_core::{Shape, ShapeError};

use crate::{analysis::Signature, error::DesignError};

/// A structure matrix: one row per residual, one column per fault.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Structure {
    /// Each residual reacts to one fault: simultaneous faults are isolated.
    Dedicated,
    /// Each residual reacts to all faults but one: more sensitive, for one fault at a time.
    Generalised,
    /// As given.
    Rows(Vec<Signature>),
}

impl Structure {
    /// The rows for a number of faults.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no fault, or a given row has not one bit per fault.
    ///
    /// # Examples
    ///
    /// ```
    /// use fd_residual::structured::Structure;
    ///
    /// let rows = Structure::Generalised.rows(3)?;
    /// assert_eq!(rows.iter().map(ToString::to_string).collect::<Vec<_>>(), ["011", "101", "110"]);
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn rows(&self, faults: usize) -> Result<Vec<Signature>, DesignError> {
        if faults == 0 {
            return Err(DesignError::Empty { what: "fault" });
        }
        let square = |own: bool| {
            let row = |i: usize| Signature((0..faults).map(|j| (i == j) == own).collect());
            (0..faults).map(row).collect()
        };
        match self {
            Self::Dedicated => Ok(square(true)),
            Self::Generalised => Ok(square(false)),
            Self::Rows(rows) => {
                let expected = Shape::new(rows.len(), faults);
                match rows.iter().map(|row| row.0.len()).find(|&len| len != faults) {
                    None if rows.is_empty() => Err(DesignError::Empty { what: "row" }),
                    None => Ok(rows.clone()),
                    Some(len) => {
                        let found = Shape::new(rows.len(), len);
                        Err(ShapeError { role: "structure matrix", expected, found }.into())
                    }
                }
            }
        }
    }
}

/// One row per fault `i`: bit `j` is set when a residual with these signatures fires for fault
/// `i` and stays silent for fault `j`; on the diagonal, when one fires for fault `i` at all.
pub(super) fn told_apart(rows: &[Signature], faults: usize) -> Vec<Signature> {
    let bit = |i: usize, j: usize| rows.iter().any(|row| row.0[i] && (i == j || !row.0[j]));
    (0..faults).map(|i| Signature((0..faults).map(|j| bit(i, j)).collect())).collect()
}
