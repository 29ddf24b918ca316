//! Inputs that drive a plant: named channels on an even time base.

use fd_core::{Shape, ShapeError};

use crate::{
    channel::Channel,
    domain::SampleTime,
    error::ModelError,
    record::Record,
    signal::{SignalError, SignalSpec},
};

/// Inputs of one run, row by row; a [`Record`] without outputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Inputs {
    channels: Vec<Channel>,
    u: Vec<f64>,
    samples: usize,
    ts: SampleTime,
    start: f64,
}

impl Inputs {
    /// Inputs from row-major values, `channels.len()` per sample.
    ///
    /// ```
    /// # use fd_model::{Channel, Inputs, SampleTime};
    /// let ts = SampleTime::new(0.1)?;
    /// let inputs = Inputs::new(Channel::numbered("u", 2), vec![1.0, 2.0, 3.0, 4.0], 2, ts)?;
    /// assert_eq!(inputs.u(1), [3.0, 4.0]);
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when the number of values is not `samples · channels.len()`.
    pub fn new(
        channels: Vec<Channel>,
        u: Vec<f64>,
        samples: usize,
        ts: SampleTime,
    ) -> Result<Self, ModelError> {
        let width = channels.len();
        if u.len() != samples * width {
            let expected = Shape::new(samples, width);
            let found = Shape::new(u.len().div_ceil(width.max(1)), width);
            return Err(ShapeError { role: "inputs u", expected, found }.into());
        }
        Ok(Self { channels, u, samples, ts, start: 0.0 })
    }

    /// Inputs from one signal per channel.
    ///
    /// ```
    /// # use fd_model::{Channel, Inputs, SampleTime, signal::Step};
    /// let fuel = (Channel::new("fuel", "kg/s"), Step::new(0.1, 0.1));
    /// let inputs = Inputs::from_signals([fuel], 3, SampleTime::new(0.1)?)?;
    /// assert_eq!((inputs.u(0), inputs.u(1)), (&[0.0][..], &[0.1][..]));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns the first signal that cannot be evaluated.
    pub fn from_signals<S: Into<SignalSpec>>(
        signals: impl IntoIterator<Item = (Channel, S)>,
        samples: usize,
        ts: SampleTime,
    ) -> Result<Self, SignalError> {
        let mut channels = Vec::new();
        let mut columns = Vec::new();
        for (channel, signal) in signals {
            channels.push(channel);
            columns.push(signal.into().values(samples, ts)?);
        }
        let u = (0..samples).flat_map(|k| columns.iter().map(move |column| column[k])).collect();
        Ok(Self { channels, u, samples, ts, start: 0.0 })
    }

    /// Sets the time of the first sample, in seconds. Signals and noise are evaluated on time
    /// since the first sample, faults on the time axis that this sets.
    #[must_use]
    pub fn starting_at(mut self, seconds: f64) -> Self {
        self.start = seconds;
        self
    }

    /// Channels.
    #[must_use]
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// All values, row by row.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.u
    }

    /// Values of sample `k`, one per channel.
    ///
    /// # Panics
    ///
    /// Panics when `k` is not below [`Inputs::len`], as indexing a slice does.
    #[must_use]
    pub fn u(&self, k: usize) -> &[f64] {
        let width = self.channels.len();
        &self.u[k * width..(k + 1) * width]
    }

    /// Time of sample `k`, in seconds.
    #[must_use]
    pub fn time(&self, k: usize) -> f64 {
        self.start + k as f64 * self.ts.seconds()
    }

    /// Time between samples.
    #[must_use]
    pub fn ts(&self) -> SampleTime {
        self.ts
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.samples
    }

    /// Whether there are no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.samples == 0
    }
}

/// The inputs of a record, for running a model beside it.
impl From<&Record> for Inputs {
    fn from(record: &Record) -> Self {
        Self {
            channels: record.inputs().to_vec(),
            u: record.samples().flat_map(|(u, _)| u.iter().copied()).collect(),
            samples: record.len(),
            ts: record.ts(),
            start: record.time(0),
        }
    }
}
