//! Healthy logs as windows of `[u; y]`, one per row, and what the channels are centred and scaled by.

use faer::{Mat, MatRef};
use fd_core::IoDims;
use fd_model::Record;

use crate::error::DataError;

/// In which units the channels meet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scaling {
    /// Every channel in units of its standard deviation, so that the units of a log do not matter.
    #[default]
    Standard,
    /// The units of the log: for channels of one kind, whose sizes mean something.
    None,
}

/// The windows of several logs.
#[derive(Clone, Debug)]
pub(crate) struct Samples<'a> {
    records: &'a [Record],
    pub io: IoDims,
}

/// What one channel is centred and scaled by.
#[derive(Clone, Debug)]
pub(crate) struct Centre {
    pub mean: Vec<f64>,
    pub scale: Vec<f64>,
}

impl<'a> Samples<'a> {
    /// Logs with the same channels.
    pub(crate) fn new(records: &'a [Record]) -> Result<Self, DataError> {
        let Some(first) = records.first() else { return Err(DataError::NoLog) };
        let io = IoDims { nu: first.inputs().len(), ny: first.outputs().len() };
        for (i, record) in records.iter().enumerate() {
            if names(record) != names(first) {
                let (expected, found) = (names(first).join(", "), names(record).join(", "));
                return Err(DataError::Channels { log: i + 1, expected, found });
            }
        }
        Ok(Self { records, io })
    }

    /// Channels of a sample.
    pub(crate) fn width(&self) -> usize {
        self.io.nu + self.io.ny
    }

    /// Calls `each` with the first sample of every window of `length` samples without a hole.
    fn windows(&self, length: usize, mut each: impl FnMut(&Record, usize)) {
        for record in self.records {
            let mut run = 0;
            for k in 0..record.len() {
                run = if record.is_complete(k) { run + 1 } else { 0 };
                if length <= run {
                    each(record, k + 1 - length);
                }
            }
        }
    }

    /// Mean and scale of every channel over all complete samples.
    pub(crate) fn centre(&self, scaling: Scaling) -> Result<Centre, DataError> {
        let m = self.width();
        let (mut mean, mut count) = (vec![0.0; m], 0_usize);
        self.windows(1, |record, k| {
            count += 1;
            for (mean, value) in mean.iter_mut().zip(record.u(k).iter().chain(record.y(k))) {
                *mean += (value - *mean) / count as f64;
            }
        });
        if count < 3 {
            return Err(DataError::TooFew { what: "mean and spread", needed: 3, found: count });
        }
        let mut squares = vec![0.0; m];
        self.windows(1, |record, k| {
            let values = record.u(k).iter().chain(record.y(k));
            for ((square, mean), value) in squares.iter_mut().zip(&mean).zip(values) {
                *square += (value - mean).powi(2);
            }
        });
        let deviations: Vec<f64> =
            squares.iter().map(|square| (square / (count - 1) as f64).sqrt()).collect();
        let all = self.records.first().map(names).unwrap_or_default();
        for ((deviation, mean), name) in deviations.iter().zip(&mean).zip(all) {
            // Below the rounding of its own mean a spread is no movement.
            if !(*deviation > 8.0 * f64::EPSILON * mean.abs() && deviation.is_normal()) {
                return Err(DataError::Constant { channel: name.to_owned() });
            }
        }
        let scale = match scaling {
            Scaling::Standard => deviations,
            Scaling::None => vec![1.0; m],
        };
        Ok(Centre { mean, scale })
    }

    /// All windows of `order + 1` samples, oldest sample first, centred and scaled; one per row.
    pub(crate) fn matrix(
        &self,
        order: usize,
        centre: &Centre,
        what: &'static str,
        needed: usize,
    ) -> Result<Mat<f64>, DataError> {
        let (length, m) = (order + 1, self.width());
        let mut rows = 0;
        self.windows(length, |_, _| rows += 1);
        if rows < needed {
            return Err(DataError::TooFew { what, needed, found: rows });
        }
        let mut all = Mat::zeros(rows, length * m);
        let mut row = 0;
        self.windows(length, |record, k| {
            for i in 0..length {
                let values = record.u(k + i).iter().chain(record.y(k + i)).enumerate();
                for (j, value) in values {
                    all[(row, i * m + j)] = (value - centre.mean[j]) / centre.scale[j];
                }
            }
            row += 1;
        });
        Ok(all)
    }
}

fn names(record: &Record) -> Vec<&str> {
    record.inputs().iter().chain(record.outputs()).map(|channel| channel.name.as_str()).collect()
}

/// Takes the mean of every column out, and returns it.
pub(crate) fn centre_columns(all: &mut Mat<f64>) -> Vec<f64> {
    let rows = all.nrows() as f64;
    (0..all.ncols())
        .map(|j| {
            let mean = (0..all.nrows()).map(|i| all[(i, j)]).sum::<f64>() / rows;
            (0..all.nrows()).for_each(|i| all[(i, j)] -= mean);
            mean
        })
        .collect()
}

/// `Aᵀ B / (n − 1)` of centred columns.
pub(crate) fn covariance(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let freedom = a.nrows().saturating_sub(1).max(1) as f64;
    let mut product = a.transpose() * b;
    for j in 0..product.ncols() {
        for i in 0..product.nrows() {
            product[(i, j)] /= freedom;
        }
    }
    product
}
