//! Columns of a linear regression that are zero outside a range of rows.

use std::ops::Range;

use fd_numeric::dot;

/// A column; rows outside `rows` are zero.
#[derive(Clone, Debug)]
pub(super) struct Column {
    pub rows: Range<usize>,
    pub values: Vec<f64>,
}

impl Column {
    /// The part of a full column in `rows`.
    pub(super) fn of(full: &[f64], rows: Range<usize>) -> Self {
        Self { values: full[rows.clone()].to_vec(), rows }
    }

    pub(super) fn dot(&self, other: &Self) -> f64 {
        let from = self.rows.start.max(other.rows.start);
        let to = self.rows.end.min(other.rows.end);
        if to <= from {
            return 0.0;
        }
        let part = |column: &Self| from - column.rows.start..to - column.rows.start;
        let (a, b) = (&self.values[part(self)], &other.values[part(other)]);
        dot(a, b)
    }

    pub(super) fn dot_full(&self, full: &[f64]) -> f64 {
        dot(&self.values, &full[self.rows.clone()])
    }
}
