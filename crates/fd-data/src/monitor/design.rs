//! What a monitor knows of healthy windows.

use faer::{Mat, MatRef};
use fd_core::{Frame, IoDims, Scalar, stage::Stage};
use fd_model::{Record, freeze};
use fd_numeric::dense::Dense;

use super::run::{Limits, Monitor};
use crate::{
    error::DataError,
    limits::{check_level, empirical, hotelling, jackson_mudholkar},
    window::WindowMapDesign,
};

/// What a method found in healthy logs.
#[derive(Clone, Debug)]
pub(crate) struct Parts {
    pub io: IoDims,
    pub order: usize,
    /// Mean and scale of every entry of a window.
    pub mean: Vec<f64>,
    pub scale: Vec<f64>,
    /// Whitened scores from a window, their way back, and what is left.
    pub scores: Mat<f64>,
    pub back: Mat<f64>,
    pub left: Mat<f64>,
    /// Whether what is left has a T² of its own.
    pub has_rest: bool,
    /// Eigenvalues of the covariance of the prediction error.
    pub error_values: Vec<f64>,
    pub windows: usize,
}

/// Scores and prediction errors of a window at design time, with limits.
#[derive(Clone, Debug)]
pub struct MonitorDesign {
    parts: Parts,
    /// `V Uᵀ` of the scores `U Σ Vᵀ`: from whitened scores to `M^½ w`.
    root: Mat<f64>,
    rest_root: Mat<f64>,
    limits: Limits,
}

/// Level of the limits that a design begins with.
const LEVEL: f64 = 0.99;

impl MonitorDesign {
    pub(crate) fn new(parts: Parts) -> Result<Self, DataError> {
        let root = root(parts.scores.as_ref())?;
        let rest_root = if parts.has_rest { root_of(&parts.left)? } else { Mat::new() };
        let none = Limits { t2: 1.0, rest: None, q: 1.0 };
        Self { parts, root, rest_root, limits: none }.limited(LEVEL)
    }

    /// The same with limits from the formulas for independent Gaussian samples, which let a share of
    /// `1 − level` of such samples pass. A new design has those of 99 %.
    ///
    /// # Errors
    ///
    /// Returns an error when `level` is not between 0 and 1.
    pub fn limited(mut self, level: f64) -> Result<Self, DataError> {
        check_level(level)?;
        let parts = &self.parts;
        let t2 = hotelling(parts.scores.nrows(), parts.windows, level)?;
        let rest = match parts.left.nrows() {
            rows if parts.has_rest && 0 < rows => Some(hotelling(rows, parts.windows, level)?),
            _ => None,
        };
        let q = jackson_mudholkar(&parts.error_values, level)?;
        self.limits = Limits { t2, rest, q };
        Ok(self)
    }

    /// The same with limits that a share of `1 − level` of the samples of `healthy` logs exceeds. Take logs that
    /// were not learned from: the others fit too well.
    ///
    /// # Errors
    ///
    /// Returns an error when `level` is not between 0 and 1, the logs have other channels, or they are too
    /// short for that level.
    pub fn calibrated(mut self, healthy: &[Record], level: f64) -> Result<Self, DataError> {
        let (mut t2, mut rest, mut q) = (Vec::new(), Vec::new(), Vec::new());
        for record in healthy {
            for statistics in self.statistics(record)?.into_iter().flatten() {
                t2.push(statistics.t2);
                rest.extend(statistics.rest);
                q.push(statistics.q);
            }
        }
        self.limits = Limits {
            t2: empirical(&t2, level)?,
            rest: self.limits.rest.map(|_| empirical(&rest, level)).transpose()?,
            q: if self.limits.q > 0.0 { empirical(&q, level)? } else { 0.0 },
        };
        Ok(self)
    }

    /// The statistics of every sample of a log; none where the window is not full. A hole empties the window.
    ///
    /// # Errors
    ///
    /// Returns an error when the log has other channels.
    pub fn statistics(
        &self,
        record: &Record,
    ) -> Result<Vec<Option<super::Statistics<f64>>>, DataError> {
        let found = IoDims { nu: record.inputs().len(), ny: record.outputs().len() };
        if found != self.parts.io {
            let words = |io: IoDims| format!("{} inputs and {} outputs", io.nu, io.ny);
            let (expected, found) = (words(self.parts.io), words(found));
            return Err(DataError::Channels { log: 1, expected, found });
        }
        let mut monitor = self.freeze::<f64>()?;
        let all = (0..record.len()).map(|k| {
            let Ok(frame) = Frame::new(found, k as u64, record.u(k), record.y(k)) else {
                Stage::<f64>::reset(&mut monitor);
                return None;
            };
            monitor.observe(frame)
        });
        Ok(all.collect())
    }

    /// Channels of a sample.
    #[must_use]
    pub fn io(&self) -> IoDims {
        self.parts.io
    }

    /// Window length minus one.
    #[must_use]
    pub fn order(&self) -> usize {
        self.parts.order
    }

    /// Number of scores.
    #[must_use]
    pub fn components(&self) -> usize {
        self.parts.scores.nrows()
    }

    /// Windows that it was learned from.
    #[must_use]
    pub fn windows(&self) -> usize {
        self.parts.windows
    }

    /// The limits.
    #[must_use]
    pub fn limits(&self) -> Limits {
        self.limits
    }

    /// From a window in units of the log to the whitened scores, whose squares sum to T².
    ///
    /// # Errors
    ///
    /// None for a design that was made.
    pub fn scores(&self) -> Result<WindowMapDesign, DataError> {
        self.map(self.parts.scores.as_ref())
    }

    /// From a window in units of the log to what the scores leave: for principal components the coordinates
    /// whose squares sum to Q, for canonical variates those whose squares sum to the T² of the rest.
    ///
    /// # Errors
    ///
    /// Returns an error when the scores leave nothing.
    pub fn residual(&self) -> Result<WindowMapDesign, DataError> {
        if self.parts.left.nrows() == 0 {
            let (expected, found) = ("fewer than all".to_owned(), self.components() as f64);
            return Err(DataError::Setting { setting: "components", expected, found });
        }
        self.map(self.parts.left.as_ref())
    }

    fn map(&self, rows: MatRef<'_, f64>) -> Result<WindowMapDesign, DataError> {
        let Parts { io, order, mean, scale, .. } = &self.parts;
        let map = Mat::from_fn(rows.nrows(), rows.ncols(), |i, j| rows[(i, j)] / scale[j]);
        let shift = |i: usize| -(0..map.ncols()).map(|j| map[(i, j)] * mean[j]).sum::<f64>();
        let constant = (0..map.nrows()).map(shift).collect();
        WindowMapDesign::new(*io, *order, map, constant)
    }

    /// Moves the monitor to run time.
    ///
    /// # Errors
    ///
    /// None for a design that was made.
    pub fn freeze<T: Scalar>(&self) -> Result<Monitor<T>, DataError> {
        let Parts { io, order, mean, scale, scores, back, left, has_rest, .. } = &self.parts;
        let rest = if *has_rest {
            let map = freeze("scores of the rest", left.as_ref())?;
            Some((map, freeze("contributions of the rest", self.rest_root.as_ref())?))
        } else {
            None
        };
        Ok(Monitor::new(
            (*io, *order),
            (mean, scale),
            (freeze("scores", scores.as_ref())?, freeze("contributions", self.root.as_ref())?),
            freeze("way back", back.as_ref())?,
            rest,
            self.limits,
        ))
    }
}

fn root_of(rows: &Mat<f64>) -> Result<Mat<f64>, DataError> {
    if rows.nrows() == 0 { Ok(Mat::zeros(rows.ncols(), 0)) } else { root(rows.as_ref()) }
}

/// `V Uᵀ` of `S = U Σ Vᵀ`, so that `V Uᵀ S = (Sᵀ S)^½`.
fn root(scores: MatRef<'_, f64>) -> Result<Mat<f64>, DataError> {
    let svd = scores
        .economic_svd()
        .map_err(|_| DataError::NoConvergence { what: "the root of the scores" })?;
    Ok(svd.V() * svd.U().transpose())
}
