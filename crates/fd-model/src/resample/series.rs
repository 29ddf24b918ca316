//! Samples at any increasing times, put on an even time base.

use fd_core::{
    Shape, ShapeError,
    memory::{Budget, reserve},
};

use super::grid::{Grid, Order, Place};
use crate::{
    channel::Channel,
    error::ModelError,
    record::Record,
    resample::{HeldInputs, ResamplePolicy, TimeBaseError, TimeBaseReport},
};

/// What needs the memory, for messages.
const EVEN: &str = "the log on its even time base";

/// Samples at times that need not be even, row by row; a missing value is NaN.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TimeSeries {
    /// Input channels.
    pub inputs: Vec<Channel>,
    /// Output channels.
    pub outputs: Vec<Channel>,
    /// Times, in seconds.
    pub t: Vec<f64>,
    /// Inputs, `inputs.len()` values per sample.
    pub u: Vec<f64>,
    /// Outputs, `outputs.len()` values per sample.
    pub y: Vec<f64>,
}

impl TimeSeries {
    /// Puts the series on an even time base.
    ///
    /// ```
    /// use fd_model::{Channel, ResamplePolicy, TimeSeries};
    ///
    /// let series = TimeSeries {
    ///     inputs: Channel::numbered("u", 1),
    ///     outputs: Channel::numbered("y", 1),
    ///     t: vec![0.0, 1.0, 2.5, 3.0],
    ///     u: vec![5.0, 6.0, 7.0, 8.0],
    ///     y: vec![0.0, 1.0, 2.5, 3.0],
    /// };
    /// let (record, report) = series.resample(&ResamplePolicy::default())?;
    /// assert_eq!(record.input(0).collect::<Vec<_>>(), [5.0, 6.0, 6.0, 8.0]);
    /// assert_eq!(record.output(0).collect::<Vec<_>>(), [0.0, 1.0, 2.0, 3.0]);
    /// assert_eq!(report.jitter_s, 0.5);
    /// # Ok::<(), fd_model::TimeBaseError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when times are not finite, do not increase, are fewer than two, or
    /// make an absurdly long record, when the values do not fit the channels, or when the policy
    /// is outside its range.
    pub fn resample(
        &self,
        policy: &ResamplePolicy,
    ) -> Result<(Record, TimeBaseReport), TimeBaseError> {
        policy.check()?;
        self.check_lengths()?;
        let order = Order::of(&self.t, policy.disorder)?;
        let grid = Grid::of(&order.kept, &self.t, policy)?;

        let (nu, ny) = (self.inputs.len(), self.outputs.len());
        let row_u = |i: usize| &self.u[i * nu..(i + 1) * nu];
        let row_y = |i: usize| &self.y[i * ny..(i + 1) * ny];
        let values = grid.samples.saturating_mul(nu.saturating_add(ny));
        let bytes = (values as u64).saturating_mul(size_of::<f64>() as u64);
        Budget::default().take(EVEN, bytes)?;
        let (mut u, mut y) = (reserve(EVEN, grid.samples * nu)?, reserve(EVEN, grid.samples * ny)?);
        let (mut cursor, mut even) = (0, true);
        let held = policy.held_inputs.unwrap_or_default();
        let between = |before: &[f64], after: &[f64], share: f64, values: &mut Vec<f64>| {
            values.extend(before.iter().zip(after).map(|(a, b)| a + share * (b - a)));
        };
        for k in 0..grid.samples {
            match grid.place(k, &mut cursor, &order.kept, &self.t) {
                Place::On(i) => {
                    u.extend_from_slice(row_u(i));
                    y.extend_from_slice(row_y(i));
                }
                Place::Between { before, after, share } => {
                    even = false;
                    if held == HeldInputs::Linear {
                        between(row_u(before), row_u(after), share, &mut u);
                    } else {
                        u.extend_from_slice(row_u(before));
                    }
                    between(row_y(before), row_y(after), share, &mut y);
                }
                Place::Gap => {
                    even = false;
                    u.extend(std::iter::repeat_n(f64::NAN, nu));
                    y.extend(std::iter::repeat_n(f64::NAN, ny));
                    continue;
                }
            }
            if held == HeldInputs::Mean {
                let row = &mut u[k * nu..];
                grid.held(k, cursor, &order.kept, &self.t, |i, share| {
                    for (mean, value) in row.iter_mut().zip(row_u(i)) {
                        *mean += share * (value - *mean);
                    }
                });
            }
        }
        let (inputs, outputs) = (self.inputs.clone(), self.outputs.clone());
        let record = Record::new(inputs, outputs, u, y, grid.step)?;
        Ok((record.starting_at(grid.start), grid.report(&order, even, self.t.len())))
    }
}

impl TimeSeries {
    fn check_lengths(&self) -> Result<(), ModelError> {
        let samples = self.t.len();
        for (role, values, width) in
            [("inputs u", &self.u, self.inputs.len()), ("outputs y", &self.y, self.outputs.len())]
        {
            if values.len() != samples * width {
                let expected = Shape::new(samples, width);
                let found = Shape::new(values.len().div_ceil(width.max(1)), width);
                return Err(ShapeError { role, expected, found }.into());
            }
        }
        Ok(())
    }
}
