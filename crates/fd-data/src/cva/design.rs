//! Learning canonical variates.

use faer::{Mat, MatRef};
use fd_model::Record;
use fd_numeric::dense::Dense;

use super::order::{Prediction, States};
use crate::{
    error::DataError,
    monitor::{MonitorDesign, Parts},
    samples::{Samples, Scaling, centre_columns, covariance},
    spectrum::Spectrum,
};

/// What to learn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CvaDesign {
    /// Samples of the past, the present one included.
    pub past: usize,
    /// Samples of the future.
    pub future: usize,
    /// How many states.
    pub states: States,
}

impl Default for CvaDesign {
    /// Two samples each, the states by Akaike's criterion.
    fn default() -> Self {
        Self { past: 2, future: 2, states: States::Aic }
    }
}

/// Canonical variates of healthy logs.
#[derive(Clone, Debug)]
pub struct Cva {
    monitor: MonitorDesign,
    correlations: Vec<f64>,
}

impl CvaDesign {
    /// Learns the variates from healthy logs: all stretches of `past + future` samples without a missing value.
    ///
    /// # Errors
    ///
    /// Returns an error when past or future are empty, there are too few stretches, there is no output, a channel
    /// never moves, the logs have different channels, or there are not as many variates as wanted.
    ///
    /// ```
    /// use fd_data::cva::{CvaDesign, States};
    /// use fd_model::{Channel, Record, SampleTime};
    ///
    /// // A lag with a noisy sensor: one state.
    /// let noise = |k: u32, step: u32| f64::from(k * step % 211) / 105.0 - 1.0;
    /// let (mut x, mut u, mut y) = (0.0, Vec::new(), Vec::new());
    /// for k in 0..2000_u32 {
    ///     u.push(noise(k, 97) + noise(k * k % 1009, 31));
    ///     y.push(x + 0.1 * noise(k * 7 % 1013, 59));
    ///     x = 0.9 * x + u[k as usize];
    /// }
    /// let one = |name| Channel::numbered(name, 1);
    /// let log = Record::new(one("u"), one("y"), u, y, SampleTime::new(1.0)?)?;
    /// let cva = CvaDesign { past: 4, future: 4, states: States::Count(1) }.learn(&[log])?;
    /// assert!(cva.correlations()[0] > 0.9 && cva.correlations()[1] < 0.5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn learn(&self, healthy: &[Record]) -> Result<Cva, DataError> {
        for (setting, found) in [("past", self.past), ("future", self.future)] {
            if found == 0 {
                let expected = "at least 1".to_owned();
                return Err(DataError::Setting { setting, expected, found: 0.0 });
            }
        }
        let samples = Samples::new(healthy)?;
        let (io, width) = (samples.io, samples.width());
        if io.ny == 0 {
            let expected = "at least 1".to_owned();
            return Err(DataError::Setting { setting: "outputs", expected, found: 0.0 });
        }
        let columns = self.past * width;
        let centre = samples.centre(Scaling::Standard)?;
        let length = self.past + self.future;
        let needed = columns + self.future * io.ny + 2;
        let mut all = samples.matrix(length - 1, &centre, "canonical variates", needed)?;
        let shift = centre_columns(&mut all);
        let rows = all.nrows();
        let past = all.subcols(0, columns);
        let future = Mat::from_fn(rows, self.future * io.ny, |i, j| {
            all[(i, columns + (j / io.ny) * width + io.nu + j % io.ny)]
        });
        let of_past = covariance(past, past);
        let whiten = whitening(of_past.as_ref())?;
        let whiten_future = whitening(covariance(future.as_ref(), future.as_ref()).as_ref())?;
        let shared = &whiten * covariance(past, future.as_ref());
        let svd = (&shared * whiten_future.transpose())
            .full_svd()
            .map_err(|_| DataError::NoConvergence { what: "canonical correlations" })?;
        // Rounding alone may put a correlation above 1.
        let correlations: Vec<f64> =
            svd.S().column_vector().iter().map(|value| value.clamp(0.0, 1.0)).collect();
        let variates = svd.U().transpose() * &whiten;
        let next = future.subcols(0, io.ny);
        let (of_next, with_next) =
            (covariance(next, next), svd.U().transpose() * shared.subcols(0, io.ny));
        let prediction = Prediction {
            output: of_next.as_ref(),
            shared: with_next.as_ref(),
            samples: rows,
            inputs: io.nu,
        };
        let states = self.states.count(&prediction, correlations.len().min(variates.nrows()))?;
        let scores = variates.subrows(0, states).to_owned();
        let left = variates.subrows(states, variates.nrows() - states).to_owned();
        let error = Mat::<f64>::identity(columns, columns) - scores.transpose() * &scores;
        let of_error = &error * &of_past * error.transpose();
        let error_values = Spectrum::of(of_error.as_ref(), "eigenvalues of the error")?.values;
        let per_window =
            |values: &[f64]| -> Vec<f64> { values.iter().copied().cycle().take(columns).collect() };
        let scale = per_window(&centre.scale);
        let mean = (per_window(&centre.mean).iter().zip(&scale).zip(&shift))
            .map(|((mean, scale), shift)| mean + scale * shift)
            .collect();
        let has_rest = left.nrows() > 0;
        let back = scores.transpose().to_owned();
        let (order, windows) = (self.past - 1, rows);
        let parts =
            Parts { io, order, mean, scale, scores, back, left, has_rest, error_values, windows };
        Ok(Cva { monitor: MonitorDesign::new(parts)?, correlations })
    }
}

impl Cva {
    /// The statistics of these variates.
    #[must_use]
    pub fn monitor(&self) -> &MonitorDesign {
        &self.monitor
    }

    /// Correlations of past and future, largest first, each between 0 and 1.
    #[must_use]
    pub fn correlations(&self) -> &[f64] {
        &self.correlations
    }
}

/// `Λ^−½ Vᵀ` of a covariance `V Λ Vᵀ`, without the directions in which nothing moves.
fn whitening(cov: MatRef<'_, f64>) -> Result<Mat<f64>, DataError> {
    let spectrum = Spectrum::of(cov, "eigenvalues of the covariance")?;
    let Spectrum { values, vectors } = &spectrum;
    let rank = spectrum.rank();
    Ok(Mat::from_fn(rank, cov.nrows(), |i, j| vectors[(j, i)] / values[i].sqrt()))
}
