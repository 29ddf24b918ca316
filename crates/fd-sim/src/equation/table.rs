//! Piecewise linear tables.

use fd_core::Scalar;
use thiserror::Error;

/// A function given by points and straight lines between them.
///
/// ```
/// use fd_sim::equation::{Outside, Table};
///
/// let pump = Table::new(vec![0.0, 1.0, 3.0], vec![0.0, 2.0, 3.0], Outside::Hold)?;
/// assert_eq!(pump.value(2.0), 2.5);
/// assert_eq!(pump.value(9.0), 3.0);
/// assert_eq!(pump.slope(2.0), 0.5);
/// # Ok::<(), fd_sim::equation::TableError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    x: Vec<f64>,
    y: Vec<f64>,
    /// Of each interval.
    slopes: Vec<f64>,
    outside: Outside,
}

/// What a table is outside its points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outside {
    /// The value of the nearest point.
    #[default]
    Hold,
    /// The first or last line, extended.
    Extend,
}

/// The points do not make a table.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TableError {
    /// Too few points, or not as many values as points.
    #[error("a table needs at least 2 points and as many values, got {x} and {y}")]
    Length {
        /// Number of points.
        x: usize,
        /// Number of values.
        y: usize,
    },
    /// A point is not finite or not above the one before.
    #[error("point {index} of a table must be finite and above the one before, got {value}")]
    NotIncreasing {
        /// Index of the point, from 0.
        index: usize,
        /// The point.
        value: f64,
    },
    /// A value is not finite.
    #[error("value {index} of a table must be finite, got {value}")]
    NotFinite {
        /// Index of the value, from 0.
        index: usize,
        /// The value.
        value: f64,
    },
}

impl Table {
    /// A table with values `y` at the points `x`.
    ///
    /// # Errors
    ///
    /// Returns an error unless there are at least two points that increase and as many values,
    /// all finite.
    pub fn new(x: Vec<f64>, y: Vec<f64>, outside: Outside) -> Result<Self, TableError> {
        if x.len() < 2 || x.len() != y.len() {
            return Err(TableError::Length { x: x.len(), y: y.len() });
        }
        let mut before = f64::NEG_INFINITY;
        for (index, &value) in x.iter().enumerate() {
            if !value.is_finite() || value <= before {
                return Err(TableError::NotIncreasing { index, value });
            }
            before = value;
        }
        if let Some((index, &value)) = y.iter().enumerate().find(|(_, value)| !value.is_finite()) {
            return Err(TableError::NotFinite { index, value });
        }
        let rise = |points: &[f64]| points[1] - points[0];
        let slopes = x.windows(2).zip(y.windows(2)).map(|(x, y)| rise(y) / rise(x)).collect();
        Ok(Self { x, y, slopes, outside })
    }

    /// The points.
    #[must_use]
    pub fn x(&self) -> &[f64] {
        &self.x
    }

    /// The values at the points.
    #[must_use]
    pub fn y(&self) -> &[f64] {
        &self.y
    }

    /// What the table is outside its points.
    #[must_use]
    pub fn outside(&self) -> Outside {
        self.outside
    }

    /// The interpolated value.
    #[must_use]
    pub fn value<T: Scalar>(&self, x: T) -> T {
        if self.outside == Outside::Hold {
            let last = self.x.len() - 1;
            if x <= T::from_design(self.x[0]) {
                return T::from_design(self.y[0]);
            }
            if T::from_design(self.x[last]) <= x {
                return T::from_design(self.y[last]);
            }
        }
        let left = self.interval(x);
        let slope = T::from_design(self.slopes[left]);
        T::from_design(self.y[left]) + slope * (x - T::from_design(self.x[left]))
    }

    /// The slope; at a point that of the interval to its right.
    #[must_use]
    pub fn slope<T: Scalar>(&self, x: T) -> T {
        let last = self.x.len() - 1;
        let is_outside = x < T::from_design(self.x[0]) || T::from_design(self.x[last]) <= x;
        if is_outside && self.outside == Outside::Hold {
            return T::zero();
        }
        T::from_design(self.slopes[self.interval(x)])
    }

    /// Index of the point at the left end of the interval that is used at `x`.
    fn interval<T: Scalar>(&self, x: T) -> usize {
        let inner = &self.x[1..self.x.len() - 1];
        inner.partition_point(|point| T::from_design(*point) <= x)
    }
}
