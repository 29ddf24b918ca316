//! Learning principal components.

use faer::Mat;
use fd_model::Record;

use super::components::{Components, Extent};
use crate::{
    error::DataError,
    monitor::{MonitorDesign, Parts},
    samples::{Samples, Scaling, centre_columns, covariance},
    spectrum::Spectrum,
};

/// What to learn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PcaDesign {
    /// Past samples beside the present one; 0 is static PCA.
    pub lags: usize,
    /// How many components.
    pub components: Components,
    /// Units of the channels.
    pub scaling: Scaling,
}

/// Principal components of healthy windows.
#[derive(Clone, Debug)]
pub struct Pca {
    monitor: MonitorDesign,
    eigenvalues: Vec<f64>,
}

impl PcaDesign {
    /// Learns the components from healthy logs: all their windows without a missing value.
    ///
    /// # Errors
    ///
    /// Returns an error when there are not more windows than entries of a window, a channel never moves, the
    /// logs have different channels, or there are not as many components as wanted.
    ///
    /// ```
    /// use fd_data::pca::{Components, PcaDesign};
    /// use fd_model::{Channel, Record, SampleTime};
    ///
    /// // Two sensors of one level, with errors of a hundredth.
    /// let y = (0..200).flat_map(|k| {
    ///     let (level, error) = (f64::from(k * 37 % 101), 0.01 * f64::from(k * 53 % 7) - 0.03);
    ///     [level / 50.0 + error, level / 50.0 - error]
    /// });
    /// let log = Record::new(vec![], Channel::numbered("y", 2), vec![], y.collect(), SampleTime::new(1.0)?)?;
    /// let design = PcaDesign { components: Components::Count(1), ..PcaDesign::default() };
    /// let pca = design.learn(&[log])?;
    /// assert!(pca.eigenvalues()[0] > 1.99 && pca.eigenvalues()[1] < 0.01);
    /// assert_eq!(pca.monitor().components(), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn learn(&self, healthy: &[Record]) -> Result<Pca, DataError> {
        let samples = Samples::new(healthy)?;
        let width = samples.width();
        let (order, columns) = (self.lags, (self.lags + 1) * width);
        let centre = samples.centre(self.scaling)?;
        let mut all = samples.matrix(order, &centre, "principal components", columns + 2)?;
        let shift = centre_columns(&mut all);
        let cov = covariance(all.as_ref(), all.as_ref());
        let spectrum = Spectrum::of(cov.as_ref(), "eigenvalues of the covariance")?;
        let rows = all.nrows();
        let extent = Extent { rows, width, order, scaling: self.scaling };
        let a = self.components.count(&spectrum, extent)?;
        let Spectrum { values, vectors } = &spectrum;
        let per_window =
            |values: &[f64]| -> Vec<f64> { values.iter().copied().cycle().take(columns).collect() };
        let scale = per_window(&centre.scale);
        let mean: Vec<f64> = (per_window(&centre.mean).iter().zip(&scale).zip(&shift))
            .map(|((mean, scale), shift)| mean + scale * shift)
            .collect();
        let monitor = MonitorDesign::new(Parts {
            io: samples.io,
            order,
            mean,
            scale,
            scores: Mat::from_fn(a, columns, |i, j| vectors[(j, i)] / values[i].sqrt()),
            back: Mat::from_fn(columns, a, |i, j| vectors[(i, j)] * values[j].sqrt()),
            left: Mat::from_fn(columns - a, columns, |i, j| vectors[(j, a + i)]),
            has_rest: false,
            error_values: values[a..].to_vec(),
            windows: rows,
        })?;
        Ok(Pca { monitor, eigenvalues: spectrum.values })
    }
}

impl Pca {
    /// The statistics of these components.
    #[must_use]
    pub fn monitor(&self) -> &MonitorDesign {
        &self.monitor
    }

    /// Eigenvalues of the covariance of the windows, largest first.
    #[must_use]
    pub fn eigenvalues(&self) -> &[f64] {
        &self.eigenvalues
    }
}
