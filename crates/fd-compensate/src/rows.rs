//! Recorded samples of several channels, checked once and borrowed.

use std::ops::Range;

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
    /// Runs do not follow one another.
    #[error(
        "a run is said to begin at sample {start}, expected {expected} or later, below {samples}"
    )]
    Start {
        /// Where it is said to begin.
        start: usize,
        /// Where it can begin at the earliest.
        expected: usize,
        /// Samples of the record.
        samples: usize,
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
/// assert!(DrivenRows::from(SampleRows::new(1, &r)?).u(1).is_empty());
/// # Ok::<(), fd_compensate::RowsError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrivenRows<'a> {
    inputs: Option<SampleRows<'a>>,
    residuals: SampleRows<'a>,
    /// Where the second run begins, and every later one.
    starts: &'a [usize],
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
        Ok(Self { inputs: Some(inputs), residuals, starts: &[] })
    }

    /// The same samples as several runs, one after the other: the second begins at the first of `starts`, and
    /// so on. What remembers past samples starts anew with each run.
    ///
    /// ```
    /// use fd_compensate::{DrivenRows, SampleRows};
    ///
    /// let rows = DrivenRows::from(SampleRows::new(1, &[0.1, 0.2, 0.3])?).in_runs(&[2])?;
    /// assert_eq!(rows.runs().collect::<Vec<_>>(), [0..2, 2..3]);
    /// # Ok::<(), fd_compensate::RowsError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when a run would be empty or begins beyond the last sample.
    pub fn in_runs(self, starts: &'a [usize]) -> Result<Self, RowsError> {
        let (mut expected, samples) = (1, self.len());
        for &start in starts {
            if !(expected..samples).contains(&start) {
                return Err(RowsError::Start { start, expected, samples });
            }
            expected = start + 1;
        }
        Ok(Self { starts, ..self })
    }

    /// The samples of each run, in order; all of them when nothing else was said.
    pub fn runs(&self) -> impl Iterator<Item = Range<usize>> + use<'a> {
        let (starts, samples) = (self.starts, self.len());
        let ends = starts.iter().copied().chain([samples]);
        std::iter::once(0).chain(starts.iter().copied()).zip(ends).map(|(from, to)| from..to)
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

    /// These stretches alone, each within a run and later than the one before; one that does not go on where
    /// another ended begins a run.
    pub(crate) fn select<'b>(
        &self,
        stretches: impl Iterator<Item = &'b Range<usize>>,
    ) -> Selection {
        let (nu, channels) = (self.inputs.map(|u| u.channels()), self.residuals.channels());
        let mut selection =
            Selection { nu, channels, u: Vec::new(), r: Vec::new(), starts: Vec::new() };
        let (mut samples, mut goes_on_at) = (0, None);
        for stretch in stretches {
            let follows =
                goes_on_at == Some(stretch.start) && !self.starts.contains(&stretch.start);
            if samples > 0 && !follows {
                selection.starts.push(samples);
            }
            for k in stretch.clone() {
                selection.u.extend_from_slice(self.u(k));
                selection.r.extend_from_slice(self.r(k));
            }
            samples += stretch.len();
            goes_on_at = Some(stretch.end);
        }
        selection
    }

    /// The residual alone.
    #[must_use]
    pub fn residuals(&self) -> SampleRows<'a> {
        self.residuals
    }
}

/// Some samples of a record, in memory of their own.
pub(crate) struct Selection {
    nu: Option<usize>,
    channels: usize,
    u: Vec<f64>,
    r: Vec<f64>,
    starts: Vec<usize>,
}

impl Selection {
    pub(crate) fn rows(&self) -> DrivenRows<'_> {
        let inputs = self.nu.map(|channels| SampleRows { channels, values: &self.u });
        let residuals = SampleRows { channels: self.channels, values: &self.r };
        DrivenRows { inputs, residuals, starts: &self.starts }
    }
}

impl<'a> From<SampleRows<'a>> for DrivenRows<'a> {
    fn from(residuals: SampleRows<'a>) -> Self {
        Self { inputs: None, residuals, starts: &[] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 0..3 and 3..5 belong together; a run of the record begins at 5, and samples are missing before 8.
    #[test]
    fn a_selection_has_runs_where_it_is_torn() {
        let r: Vec<f64> = (0..10).map(f64::from).collect();
        let u: Vec<f64> = r.iter().flat_map(|v| [10.0 * v, 20.0 * v]).collect();
        let rows =
            DrivenRows::new(SampleRows::new(2, &u).unwrap(), SampleRows::new(1, &r).unwrap());
        let rows = rows.unwrap().in_runs(&[5]).unwrap();
        let selection = rows.select([0..3, 3..5, 5..7, 8..10].iter());
        let selected = selection.rows();
        assert_eq!(selected.runs().collect::<Vec<_>>(), [0..5, 5..7, 7..9]);
        assert_eq!((selected.nu(), selected.len()), (2, 9));
        assert_eq!((selected.u(7), selected.r(7)), (&[80.0, 160.0][..], &[8.0][..]));
        let whole = rows.select(std::iter::once(&(5..10)));
        assert_eq!(whole.rows().runs().collect::<Vec<_>>(), vec![0..5]);
    }
}
