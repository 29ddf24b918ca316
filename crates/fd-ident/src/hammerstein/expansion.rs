//! From inputs to functions of inputs, at design time.

use std::borrow::Borrow;

use fd_model::{Channel, Record};
use serde::{Deserialize, Serialize};

use crate::{arx::check_records, error::IdentError};

/// Which functions of an input.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Basis {
    /// `u, u², … u^degree`.
    Polynomial {
        /// Highest power.
        degree: usize,
    },
    /// Straight lines that meet in knots: `u, max(u − knot, 0), …`. The knots are placed so that
    /// every piece holds equally many training samples.
    PiecewiseLinear {
        /// Number of pieces.
        segments: usize,
    },
}

/// The functions of one input and the range that they were learned on.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Highest power, at least 1.
    pub degree: usize,
    /// Knots of the hinges.
    pub knots: Vec<f64>,
    /// Least training input.
    pub low: f64,
    /// Largest training input.
    pub high: f64,
}

impl Curve {
    /// Number of functions.
    #[must_use]
    pub fn len(&self) -> usize {
        self.degree + self.knots.len()
    }

    /// Whether there are no functions; never for a curve of an [`Expansion`].
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Functions of all inputs.
///
/// # Examples
///
/// ```
/// use fd_ident::hammerstein::{Basis, Expansion};
/// use fd_model::{Channel, Record, SampleTime};
///
/// let (u, y) = (vec![-1.0, 0.0, 2.0], vec![0.0; 3]);
/// let ts = SampleTime::new(0.1)?;
/// let record = Record::new(Channel::numbered("u", 1), Channel::numbered("y", 1), u, y, ts)?;
/// let square = Expansion::from_training(Basis::Polynomial { degree: 2 }, &[&record])?;
/// assert_eq!(square.expand(&record)?.u(2), [2.0, 4.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Expansion {
    pub(super) curves: Vec<Curve>,
}

impl Expansion {
    /// The same functions for every input, with range and knots from training data.
    ///
    /// # Errors
    ///
    /// Returns an error without records or inputs, when an input is missing throughout, or when
    /// the basis has no function.
    pub fn from_training<R: Borrow<Record>>(
        basis: Basis,
        records: &[R],
    ) -> Result<Self, IdentError> {
        let first = check_records(records)?;
        let (degree, segments) = match basis {
            Basis::Polynomial { degree } => (degree, 1),
            Basis::PiecewiseLinear { segments } => (1, segments),
        };
        for (setting, found) in [("degree", degree), ("segments", segments)] {
            if found == 0 {
                let expected = "at least 1";
                return Err(IdentError::Setting { setting, expected, found: 0.0 });
            }
        }
        let curve = |input: usize| {
            let mut values: Vec<f64> = records
                .iter()
                .flat_map(|record| record.borrow().input(input))
                .filter(|u| u.is_finite())
                .collect();
            values.sort_by(f64::total_cmp);
            let (Some(&low), Some(&high)) = (values.first(), values.last()) else {
                let (role, row, value) = ("training input", 0, f64::NAN);
                return Err(IdentError::NonFinite { role, row, col: input, value });
            };
            let mut knots: Vec<f64> =
                (1..segments).map(|i| values[i * (values.len() - 1) / segments]).collect();
            // Equal samples would make equal hinges.
            knots.dedup_by(|a, b| (*a - *b).abs() <= 1e-9 * (high - low));
            knots.retain(|&knot| low < knot && knot < high);
            Ok(Curve { degree, knots, low, high })
        };
        let curves = (0..first.inputs().len()).map(curve).collect::<Result<_, _>>()?;
        Ok(Self { curves })
    }

    /// The functions of each input.
    #[must_use]
    pub fn curves(&self) -> &[Curve] {
        &self.curves
    }

    /// Number of inputs.
    #[must_use]
    pub fn nu(&self) -> usize {
        self.curves.len()
    }

    /// Number of functions of all inputs.
    #[must_use]
    pub fn expanded_len(&self) -> usize {
        self.curves.iter().map(Curve::len).sum()
    }

    /// The record with the functions in place of the inputs; missing where the input is missing.
    ///
    /// # Errors
    ///
    /// Returns an error when the record has another number of inputs.
    pub fn expand(&self, record: &Record) -> Result<Record, IdentError> {
        let (expected, found) = (self.nu(), record.inputs().len());
        if expected != found {
            return Err(IdentError::ModelMismatch { what: "number of inputs", expected, found });
        }
        let expander = self.freeze::<f64>();
        let width = self.expanded_len();
        let mut u = vec![0.0; record.len() * width];
        let mut y = Vec::with_capacity(record.len() * record.outputs().len());
        for (k, row) in u.chunks_exact_mut(width.max(1)).enumerate() {
            expander.expand_into(record.u(k), row);
        }
        (0..record.len()).for_each(|k| y.extend_from_slice(record.y(k)));
        let inputs = Channel::numbered("x", width);
        let expanded = Record::new(inputs, record.outputs().to_vec(), u, y, record.ts())?;
        Ok(expanded.starting_at(record.time(0)))
    }
}
