//! Learning parity relations.

use faer::Mat;
use fd_model::Record;
use fd_numeric::dense::Dense;

use crate::{
    error::DataError,
    samples::{Centre, Samples, Scaling, centre_columns},
    window::WindowMapDesign,
};

/// What to learn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DataParityDesign {
    /// Window length minus one.
    pub order: usize,
    /// States of the plant; none counts them.
    pub states: Option<usize>,
}

/// Parity relations of healthy logs.
#[derive(Clone, Debug)]
pub struct DataParity {
    map: WindowMapDesign,
    states: usize,
    singular_values: Vec<f64>,
    noise: f64,
}

impl DataParityDesign {
    /// Learns all relations of this order from healthy logs: all stretches of twice the window without a missing
    /// value.
    ///
    /// # Errors
    ///
    /// Returns an error when there are too few stretches, a channel never moves, the inputs do not excite, the
    /// states leave no relation, or the logs have different channels.
    ///
    /// ```
    /// use fd_data::parity::DataParityDesign;
    /// use fd_model::{Channel, Record, SampleTime};
    ///
    /// // y(k) = 0.5 y(k−1) + u(k−1), exactly.
    /// let u: Vec<f64> = (0..200_u32).map(|k| f64::from(k * k * 7 % 19) - 9.0).collect();
    /// let mut y = vec![0.0];
    /// (1..200).for_each(|k| y.push(0.5 * y[k - 1] + u[k - 1]));
    /// let one = |name| Channel::numbered(name, 1);
    /// let log = Record::new(one("u"), one("y"), u, y, SampleTime::new(1.0)?)?;
    /// let parity = DataParityDesign { order: 1, states: None }.learn(&[log])?;
    /// let k = parity.map().map(); // of [u(k−1), y(k−1), u(k), y(k)]
    /// assert_eq!((parity.states(), k.nrows()), (1, 1));
    /// assert!((k[(0, 1)] / k[(0, 3)] + 0.5).abs() < 1e-9 && (k[(0, 0)] / k[(0, 3)] + 1.0).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn learn(&self, healthy: &[Record]) -> Result<DataParity, DataError> {
        let samples = Samples::new(healthy)?;
        let (io, width, length) = (samples.io, samples.width(), self.order + 1);
        let (before, du, dy) = (length * width, length * io.nu, length * io.ny);
        let centre = samples.centre(Scaling::Standard)?;
        let needed = before + du + dy + 2;
        let mut all = samples.matrix(2 * length - 1, &centre, "parity relations", needed)?;
        let shift = centre_columns(&mut all);
        // Where the columns of the later window stand: all its inputs first, then all its outputs.
        let place = |j: usize| {
            let (i, of, first) = if j < du { (j, io.nu, 0) } else { (j - du, io.ny, io.nu) };
            before + (i / of) * width + first + i % of
        };
        let rows = all.nrows();
        let column = |j: usize| if j < before { j } else { place(j - before) };
        let sorted = Mat::from_fn(rows, before + du + dy, |i, j| all[(i, column(j))]);
        let l = sorted.factor_qr().thin_R().transpose().to_owned();
        let size = (rows as f64).sqrt();
        let known = Mat::from_fn(du + dy, before + du, |i, j| l[(before + i, j)] / size);
        let left = Mat::from_fn(dy, dy, |i, j| l[(before + du + i, before + du + j)] / size);
        let no = |what| move |_| DataError::NoConvergence { what };
        let svd = known.full_svd().map_err(no("singular values of the windows"))?;
        let values: Vec<f64> = svd.S().column_vector().iter().copied().collect();
        let largest = values.first().copied().unwrap_or(0.0);
        let noise = left
            .sigmas()
            .map_err(no("singular values of the noise"))?
            .first()
            .copied()
            .unwrap_or(0.0);
        // Noise of that size in `rows` samples leaves singular values of a dy × (before + du) matrix of at most
        // (√dy + √(before + du) + 3) / √rows, but in one log out of a hundred (Davidson and Szarek 2001).
        let chance = noise * ((dy as f64).sqrt() + ((before + du) as f64).sqrt() + 3.0) / size;
        // The factorisation rounds relative to the largest value, thousands of entries of ε each.
        let least = chance.max(1e-11 * largest);
        let rank = values.iter().take_while(|&&value| value > least).count();
        let excited = known
            .subrows(0, du)
            .sigmas()
            .map_err(no("singular values of the inputs"))?
            .iter()
            .filter(|&&value| value > 1e-9 * largest)
            .count();
        if excited < du {
            return Err(DataError::Excitation { window: length, expected: du, found: excited });
        }
        let states = self.states.unwrap_or_else(|| rank.saturating_sub(du));
        if dy <= states {
            return Err(DataError::NoParity { order: self.order, states, outputs: dy });
        }
        // Columns of U beyond the rank, back in the order of a window and in units of the log.
        let vector = |i: usize, j: usize| svd.U()[(j, du + states + i)];
        let mut of_window = Mat::zeros(dy - states, before);
        for (j, i) in (0..du + dy).flat_map(|j| (0..dy - states).map(move |i| (j, i))) {
            of_window[(i, place(j) - before)] = vector(i, j);
        }
        let map = in_units(&of_window, &centre);
        let means = (0..before)
            .map(|j| centre.mean[j % width] + centre.scale[j % width] * shift[before + j]);
        let means: Vec<f64> = means.collect();
        let constant = (0..map.nrows())
            .map(|i| -(0..before).map(|j| map[(i, j)] * means[j]).sum::<f64>())
            .collect();
        let map = WindowMapDesign::new(io, self.order, map, constant)?;
        Ok(DataParity { map, states, singular_values: values, noise: chance })
    }
}

fn in_units(rows: &Mat<f64>, centre: &Centre) -> Mat<f64> {
    let width = centre.scale.len();
    Mat::from_fn(rows.nrows(), rows.ncols(), |i, j| rows[(i, j)] / centre.scale[j % width])
}

impl DataParity {
    /// The relations, one per residual, of windows in units of the log.
    #[must_use]
    pub fn map(&self) -> &WindowMapDesign {
        &self.map
    }

    /// States of the plant, given or counted.
    #[must_use]
    pub fn states(&self) -> usize {
        self.states
    }

    /// Singular values of the windows that the past and the inputs foretell, largest first: so many for the
    /// inputs, then those of the states.
    #[must_use]
    pub fn singular_values(&self) -> &[f64] {
        &self.singular_values
    }

    /// The largest singular value that noise alone would leave.
    #[must_use]
    pub fn noise(&self) -> f64 {
        self.noise
    }
}
