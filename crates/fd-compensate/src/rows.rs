//! Recorded samples of several channels, checked once and borrowed.

use thiserror::Error;

/// Samples of one or more channels, stored sample by sample, all of them finite.
///
/// ```
/// use fd_compensate::SampleRows;
///
/// let rows = SampleRows::new(2, &[1.0, 10.0, 2.0, 20.0])?;
/// assert_eq!(rows.len(), 2);
/// assert_eq!(rows.row(1), [2.0, 20.0]);
/// # Ok::<(), fd_compensate::RowsError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleRows<'a> {
    channels: usize,
    values: &'a [f64],
}

/// Values that are not a table of finite samples.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RowsError {
    /// There is nothing to learn from.
    #[error(
        "expected at least one sample of at least one channel, got {found} values for {channels} channels"
    )]
    Empty {
        /// Channels asked for.
        channels: usize,
        /// Values given.
        found: usize,
    },
    /// The values do not make whole samples.
    #[error("{found} values do not make whole samples of {channels} channels")]
    Ragged {
        /// Channels asked for.
        channels: usize,
        /// Values given.
        found: usize,
    },
    /// Inputs and residual of a record have different lengths.
    #[error("{inputs} samples of the input for {residuals} of the residual")]
    Lengths {
        /// Samples of the input.
        inputs: usize,
        /// Samples of the residual.
        residuals: usize,
    },
    /// A sample is NaN or infinite.
    #[error("sample {k}, channel {channel}: expected a finite number, found {found}")]
    NonFinite {
        /// Sample index.
        k: usize,
        /// Channel index.
        channel: usize,
        /// What was found.
        found: f64,
    },
}

impl<'a> SampleRows<'a> {
    /// Borrows `values`, of which each `channels` in a row are one sample.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no sample, when the last one is incomplete, or when a
    /// value is not finite.
    pub fn new(channels: usize, values: &'a [f64]) -> Result<Self, RowsError> {
        let found = values.len();
        if channels == 0 || found == 0 {
            return Err(RowsError::Empty { channels, found });
        }
        if !found.is_multiple_of(channels) {
            return Err(RowsError::Ragged { channels, found });
        }
        match values.iter().position(|v| !v.is_finite()) {
            Some(at) => {
                let (k, channel, found) = (at / channels, at % channels, values[at]);
                Err(RowsError::NonFinite { k, channel, found })
            }
            None => Ok(Self { channels, values }),
        }
    }

    /// Number of channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Number of samples, at least one.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "there is always a sample")]
    pub fn len(&self) -> usize {
        self.values.len() / self.channels
    }

    /// Sample `k`.
    #[must_use]
    pub fn row(&self, k: usize) -> &'a [f64] {
        &self.values[k * self.channels..(k + 1) * self.channels]
    }

    /// All samples in order.
    #[must_use]
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &'a [f64]> + use<'a> {
        self.values.chunks_exact(self.channels)
    }

    /// The values of one channel in order.
    pub fn channel(&self, channel: usize) -> impl Iterator<Item = f64> + use<'a> {
        self.values.iter().skip(channel).step_by(self.channels).copied()
    }

    /// Reduces each channel to one number.
    pub(crate) fn per_channel(&self, f: impl Fn(&mut dyn Iterator<Item = f64>) -> f64) -> Vec<f64> {
        (0..self.channels).map(|channel| f(&mut self.channel(channel))).collect()
    }
}

/// A residual with the input that drove the plant, sample by sample.
///
/// Detectors that look at the residual alone do not need the input: a residual by itself is a record
/// of no inputs.
///
/// ```
/// use fd_compensate::{DrivenRows, SampleRows};
///
/// let (u, r) = ([1.0, 2.0], [0.1, 0.2]);
/// let rows = DrivenRows::new(SampleRows::new(1, &u)?, SampleRows::new(1, &r)?)?;
/// assert_eq!((rows.u(1), rows.r(1)), (&[2.0][..], &[0.2][..]));
/// assert_eq!(DrivenRows::from(SampleRows::new(1, &r)?).u(1), []);
/// # Ok::<(), fd_compensate::RowsError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrivenRows<'a> {
    inputs: Option<SampleRows<'a>>,
    residuals: SampleRows<'a>,
}

impl<'a> DrivenRows<'a> {
    /// Joins inputs and residual of the same samples.
    ///
    /// # Errors
    ///
    /// Returns an error when their lengths differ.
    pub fn new(inputs: SampleRows<'a>, residuals: SampleRows<'a>) -> Result<Self, RowsError> {
        if inputs.len() != residuals.len() {
            let (inputs, residuals) = (inputs.len(), residuals.len());
            return Err(RowsError::Lengths { inputs, residuals });
        }
        Ok(Self { inputs: Some(inputs), residuals })
    }

    /// Number of inputs; 0 when only the residual was recorded.
    #[must_use]
    pub fn nu(&self) -> usize {
        self.inputs.map_or(0, |inputs| inputs.channels())
    }

    /// Number of samples, at least one.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "there is always a sample")]
    pub fn len(&self) -> usize {
        self.residuals.len()
    }

    /// Input at sample `k`; empty when only the residual was recorded.
    #[must_use]
    pub fn u(&self, k: usize) -> &'a [f64] {
        self.inputs.map_or(&[], |inputs| inputs.row(k))
    }

    /// Residual at sample `k`.
    #[must_use]
    pub fn r(&self, k: usize) -> &'a [f64] {
        self.residuals.row(k)
    }

    /// The residual alone.
    #[must_use]
    pub fn residuals(&self) -> SampleRows<'a> {
        self.residuals
    }
}

impl<'a> From<SampleRows<'a>> for DrivenRows<'a> {
    fn from(residuals: SampleRows<'a>) -> Self {
        Self { inputs: None, residuals }
    }
}
