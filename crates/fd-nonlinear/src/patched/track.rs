//! The estimate of parameters that walk at random.

use fd_core::StateVisitor;

/// A tracked parameter at run time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    pub parameter: usize,
    pub variance: f64,
    pub shift: f64,
    pub bounds: [f64; 2],
}

/// Distances of the parameters from their values, with their covariance.
#[derive(Clone, Debug)]
pub(super) struct Track {
    axes: Vec<Axis>,
    pub distance: Vec<f64>,
    /// Covariance, row by row.
    covariance: Vec<f64>,
    /// `P ψ`.
    gain: Vec<f64>,
}

impl Track {
    pub(super) fn new(axes: &[Axis]) -> Self {
        let n = axes.len();
        let (distance, covariance, gain) = (vec![0.0; n], vec![0.0; n * n], vec![0.0; n]);
        Self { axes: axes.to_vec(), distance, covariance, gain }
    }

    pub(super) fn reset(&mut self) {
        self.distance.fill(0.0);
        self.covariance.fill(0.0);
    }

    pub(super) fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
        visitor.reals("distances of tracked parameters", &mut self.distance);
        visitor.reals("their covariance", &mut self.covariance);
    }

    /// A step of the walk.
    pub(super) fn walk(&mut self) {
        let n = self.axes.len();
        for (i, axis) in self.axes.iter().enumerate() {
            self.covariance[i * n + i] += axis.variance;
        }
    }

    /// Learns from one output: `error` is what is left of it, `slopes` is how it depends on the parameters.
    pub(super) fn learn(&mut self, error: f64, slopes: &[f64], variance: f64) {
        let n = self.axes.len();
        for (gain, row) in self.gain.iter_mut().zip(self.covariance.chunks_exact(n.max(1))) {
            *gain = fd_numeric::dot(row, slopes);
        }
        let spread = fd_numeric::dot(&self.gain, slopes) + variance;
        if !(spread > 0.0 && spread.is_finite()) {
            return;
        }
        for (i, row) in self.covariance.chunks_exact_mut(n.max(1)).enumerate() {
            for (p, gain) in row.iter_mut().zip(&self.gain) {
                // Symmetric to the bit.
                *p -= self.gain[i] * gain / spread;
            }
            // Rounding must not make a variance negative.
            row[i] = row[i].max(0.0);
        }
        for ((gain, distance), axis) in self.gain.iter().zip(&mut self.distance).zip(&self.axes) {
            let aim = *distance + gain * error / spread;
            *distance = aim.clamp(axis.bounds[0], axis.bounds[1]);
        }
    }
}
