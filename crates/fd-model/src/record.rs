//! Recorded signals: the one form in which data travels between files, methods and reports.

use fd_core::{Shape, ShapeError};

use crate::{channel::Channel, domain::SampleTime, error::ModelError};

mod blocks;
mod decimate;
mod error;
mod join;
mod scaling;
mod unit_change;

pub use self::{
    blocks::MissingCounts,
    error::RecordError,
    scaling::{ChannelScale, Scaling},
};

/// Inputs and outputs of one run on an even time base.
///
/// Samples are stored row by row, so that [`Record::u`] and [`Record::y`] can be fed to a
/// pipeline as they are. A missing sample is NaN in the channels that are missing.
///
/// # Examples
///
/// ```
/// use fd_model::{Channel, Record, SampleTime};
///
/// let ts = SampleTime::new(0.1)?;
/// let (u, y) = (vec![0.0, 1.0, 1.0], vec![0.0, 0.0, 0.5]);
/// let record = Record::new(Channel::numbered("u", 1), Channel::numbered("y", 1), u, y, ts)?;
/// assert_eq!(record.len(), 3);
/// assert_eq!(record.y(2), [0.5]);
/// # Ok::<(), fd_model::ModelError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    inputs: Vec<Channel>,
    outputs: Vec<Channel>,
    u: Vec<f64>,
    y: Vec<f64>,
    ts: SampleTime,
    start: f64,
    /// Samples of the same run before the first one.
    before: usize,
}

impl Record {
    /// A record from row-major samples: `u` has `inputs.len()` values per sample, `y` has
    /// `outputs.len()`.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no output channel, or the numbers of values do not make
    /// equally many whole samples.
    pub fn new(
        inputs: Vec<Channel>,
        outputs: Vec<Channel>,
        u: Vec<f64>,
        y: Vec<f64>,
        ts: SampleTime,
    ) -> Result<Self, ModelError> {
        if outputs.is_empty() {
            return Err(ModelError::NoOutputs);
        }
        let samples = y.len() / outputs.len();
        for (role, values, width) in
            [("recorded inputs u", &u, inputs.len()), ("recorded outputs y", &y, outputs.len())]
        {
            if values.len() != samples * width {
                let expected = Shape::new(samples, width);
                let found = Shape::new(values.len().div_ceil(width.max(1)), width);
                return Err(ShapeError { role, expected, found }.into());
            }
        }
        Ok(Self { inputs, outputs, u, y, ts, start: 0.0, before: 0 })
    }

    /// A record from samples `(u, y)`, one value per channel in each.
    ///
    /// ```
    /// # use fd_model::{Channel, Record, SampleTime};
    /// let rows = [([1.0], [10.0]), ([2.0], [20.0])];
    /// let ts = SampleTime::new(0.1)?;
    /// let record =
    ///     Record::from_rows(Channel::numbered("u", 1), Channel::numbered("y", 1), rows, ts)?;
    /// assert_eq!(record.y(1), [20.0]);
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when there is no output channel or a row has the wrong number of values.
    pub fn from_rows<U: AsRef<[f64]>, Y: AsRef<[f64]>>(
        inputs: Vec<Channel>,
        outputs: Vec<Channel>,
        rows: impl IntoIterator<Item = (U, Y)>,
        ts: SampleTime,
    ) -> Result<Self, ModelError> {
        let (mut u, mut y) = (Vec::new(), Vec::new());
        for (row_u, row_y) in rows {
            for (role, row, width) in [
                ("row of inputs u", row_u.as_ref(), inputs.len()),
                ("row of outputs y", row_y.as_ref(), outputs.len()),
            ] {
                if row.len() != width {
                    let (expected, found) = (Shape::new(1, width), Shape::new(1, row.len()));
                    return Err(ShapeError { role, expected, found }.into());
                }
            }
            u.extend_from_slice(row_u.as_ref());
            y.extend_from_slice(row_y.as_ref());
        }
        Self::new(inputs, outputs, u, y, ts)
    }

    /// Sets the time of the first sample, in seconds.
    #[must_use]
    pub fn starting_at(mut self, seconds: f64) -> Self {
        self.start = seconds;
        self
    }

    /// The same samples as a run of its own, of which nobody knows what came before.
    #[must_use]
    pub fn as_its_own_run(self) -> Self {
        Self { before: 0, ..self }
    }

    /// The same samples, at the place in its run that another record has.
    ///
    /// ```
    /// use fd_model::{Channel, Record, SampleTime};
    ///
    /// let (u, y) = (Channel::numbered("u", 1), Channel::numbered("y", 1));
    /// let all = Record::new(u, y, vec![0.0; 9], vec![0.0; 9], SampleTime::new(0.1)?)?;
    /// let late = all.clone().at_the_place_of(&all.slice(2, 9));
    /// assert_eq!((late.samples_before(), late.len()), (2, 9));
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    #[must_use]
    pub fn at_the_place_of(self, other: &Self) -> Self {
        Self { start: other.start, before: other.before, ..self }
    }

    /// Samples of the same run before the first one, of which this is a [`slice`](Self::slice).
    ///
    /// ```
    /// use fd_model::{Channel, Record, SampleTime};
    ///
    /// let (u, y) = (Channel::numbered("u", 1), Channel::numbered("y", 1));
    /// let all = Record::new(u, y, vec![0.0; 9], vec![0.0; 9], SampleTime::new(0.1)?)?;
    /// let late = all.slice(2, 9).slice(4, 6);
    /// assert_eq!((all.samples_before(), late.samples_before()), (0, 6));
    /// assert_eq!(late.as_its_own_run().samples_before(), 0);
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    #[must_use]
    pub fn samples_before(&self) -> usize {
        self.before
    }

    /// Input channels.
    #[must_use]
    pub fn inputs(&self) -> &[Channel] {
        &self.inputs
    }

    /// Output channels.
    #[must_use]
    pub fn outputs(&self) -> &[Channel] {
        &self.outputs
    }

    /// Index of the input channel with this name.
    #[must_use]
    pub fn input_index(&self, name: &str) -> Option<usize> {
        self.inputs.iter().position(|channel| channel.name == name)
    }

    /// Index of the output channel with this name.
    #[must_use]
    pub fn output_index(&self, name: &str) -> Option<usize> {
        self.outputs.iter().position(|channel| channel.name == name)
    }

    /// Inputs of sample `k`, one value per input channel.
    ///
    /// # Panics
    ///
    /// Panics when `k` is not below [`Record::len`], as indexing a slice does.
    #[must_use]
    pub fn u(&self, k: usize) -> &[f64] {
        let width = self.inputs.len();
        &self.u[k * width..(k + 1) * width]
    }

    /// Outputs of sample `k`, one value per output channel.
    ///
    /// # Panics
    ///
    /// Panics when `k` is not below [`Record::len`], as indexing a slice does.
    #[must_use]
    pub fn y(&self, k: usize) -> &[f64] {
        let width = self.outputs.len();
        &self.y[k * width..(k + 1) * width]
    }

    /// Outputs of sample `k`, to be changed, for example by a sensor fault.
    ///
    /// # Panics
    ///
    /// Panics when `k` is not below [`Record::len`], as indexing a slice does.
    pub fn y_mut(&mut self, k: usize) -> &mut [f64] {
        let width = self.outputs.len();
        &mut self.y[k * width..(k + 1) * width]
    }

    /// Samples `(u, y)` in order of time.
    #[must_use]
    pub fn samples(&self) -> impl ExactSizeIterator<Item = (&[f64], &[f64])> + '_ {
        (0..self.len()).map(|k| (self.u(k), self.y(k)))
    }

    /// One input over time.
    #[must_use]
    pub fn input(&self, channel: usize) -> impl ExactSizeIterator<Item = f64> + '_ {
        (0..self.len()).map(move |k| self.u(k)[channel])
    }

    /// One output over time.
    #[must_use]
    pub fn output(&self, channel: usize) -> impl ExactSizeIterator<Item = f64> + '_ {
        (0..self.len()).map(move |k| self.y(k)[channel])
    }

    /// Whether every channel of sample `k` is there.
    #[must_use]
    pub fn is_complete(&self, k: usize) -> bool {
        self.u(k).iter().chain(self.y(k)).all(|v| v.is_finite())
    }

    /// The part from sample `from` up to but not including sample `to`, clamped to what there is.
    #[must_use]
    pub fn slice(&self, from: usize, to: usize) -> Self {
        let to = to.min(self.len());
        let from = from.min(to);
        let part = |values: &[f64], width: usize| values[from * width..to * width].to_vec();
        Self {
            inputs: self.inputs.clone(),
            outputs: self.outputs.clone(),
            u: part(&self.u, self.inputs.len()),
            y: part(&self.y, self.outputs.len()),
            ts: self.ts,
            start: self.time(from),
            before: self.before + from,
        }
    }

    /// Time of sample `k`, in seconds.
    #[must_use]
    pub fn time(&self, k: usize) -> f64 {
        self.start + k as f64 * self.ts.seconds()
    }

    /// Samples from where the run of an `earlier` record on the same clock began to this one.
    ///
    /// ```
    /// use fd_model::{Channel, Record, SampleTime};
    ///
    /// let (u, y) = (Channel::numbered("u", 1), Channel::numbered("y", 1));
    /// let run = Record::new(u, y, vec![0.0; 9], vec![0.0; 9], SampleTime::new(0.1)?)?;
    /// assert_eq!(run.clone().starting_at(5.02).samples_since(&run.slice(2, 9)), 50);
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "not before the earlier one, and far below 2^64"
    )]
    pub fn samples_since(&self, earlier: &Self) -> usize {
        let samples = (self.start - earlier.start) / self.ts.seconds();
        earlier.before + samples.round().max(0.0) as usize
    }

    /// Whether this record goes on where an `earlier` one ended, to within half a sample.
    ///
    /// ```
    /// use fd_model::{Channel, Record, SampleTime};
    ///
    /// let (u, y) = (Channel::numbered("u", 1), Channel::numbered("y", 1));
    /// let all = Record::new(u, y, vec![0.0; 9], vec![0.0; 9], SampleTime::new(0.1)?)?;
    /// assert!(all.slice(6, 9).continues(&all.slice(0, 6)) && !all.continues(&all));
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    #[must_use]
    pub fn continues(&self, earlier: &Self) -> bool {
        (earlier.time(earlier.len()) - self.start).abs() < 0.5 * self.ts.seconds()
    }

    /// Whether this record begins where an `earlier` one on the same clock ended, to within half a sample, or later. Records
    /// that begin at zero have clocks of their own.
    ///
    /// ```
    /// use fd_model::{Channel, Record, SampleTime};
    ///
    /// let (u, y) = (Channel::numbered("u", 1), Channel::numbered("y", 1));
    /// let run = Record::new(u, y, vec![0.0; 9], vec![0.0; 9], SampleTime::new(0.1)?)?;
    /// assert!(run.clone().starting_at(5.0).comes_after(&run) && !run.comes_after(&run));
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    #[must_use]
    pub fn comes_after(&self, earlier: &Self) -> bool {
        earlier.time(earlier.len()) - self.start < 0.5 * self.ts.seconds()
    }

    /// Time between samples.
    #[must_use]
    pub fn ts(&self) -> SampleTime {
        self.ts
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.y.len() / self.outputs.len()
    }

    /// Whether there are no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.y.is_empty()
    }
}

#[cfg(test)]
mod tests;
