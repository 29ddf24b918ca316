//! The mean and the covariance of the state, as the samples leave them.

use fd_core::StateVisitor;

use crate::{
    array::{solve_lower, triangularise},
    noise::NoisyModel,
};

/// Largest number of a sample that equations are asked about: 34 years at a kilohertz.
pub(crate) const MOST_SAMPLES: u64 = 1 << 40;

/// The estimate of the state, before or after the outputs of a sample.
#[derive(Clone, Debug)]
pub(crate) struct Estimate {
    start: Vec<f64>,
    initial: Vec<f64>,
    process: Vec<f64>,
    output: Vec<f64>,
    /// Mean.
    pub x: Vec<f64>,
    /// Factor of the covariance, lower triangular, row by row.
    pub s: Vec<f64>,
    /// Inputs of the sample before.
    u: Vec<f64>,
    /// Samples so far.
    samples: u64,
    /// Whether the sample before has left an estimate to go on from.
    goes_on: bool,
    /// The array that is triangularised, and the innovation in units of its spread.
    work: Vec<f64>,
    z: Vec<f64>,
}

/// Deviations from the mean, one per column: those of the states row by row, then those of the outputs.
#[derive(Clone, Debug)]
pub(crate) struct Deviations {
    pub columns: usize,
    pub x: Vec<f64>,
    pub y: Vec<f64>,
}

impl Deviations {
    pub(crate) fn new(nx: usize, ny: usize, columns: usize) -> Self {
        Self { columns, x: vec![0.0; nx * columns], y: vec![0.0; ny * columns] }
    }
}

impl Estimate {
    pub(crate) fn new(model: &NoisyModel, columns: usize) -> Self {
        let (nx, io, noise) = (model.nx(), model.io(), model.noise());
        let updated = (io.ny + nx) * (io.ny + columns);
        let predicted = nx * (columns + nx);
        let mut made = Self {
            start: model.start().to_vec(),
            initial: noise.initial.clone(),
            process: noise.process.clone(),
            output: noise.output.clone(),
            x: vec![0.0; nx],
            s: vec![0.0; nx * nx],
            u: vec![0.0; io.nu],
            samples: 0,
            goes_on: false,
            work: vec![0.0; updated.max(predicted)],
            z: vec![0.0; io.ny],
        };
        made.begin();
        made
    }

    pub(crate) fn nx(&self) -> usize {
        self.x.len()
    }

    /// Number of this sample, and the inputs of the sample before, if there is one.
    pub(crate) fn at(&self) -> (u64, Option<&[f64]>) {
        let sample = self.samples.min(MOST_SAMPLES);
        (sample, (self.goes_on && 0 < sample).then_some(self.u.as_slice()))
    }

    /// Forgets all samples.
    pub(crate) fn restart(&mut self) {
        self.begin();
        self.samples = 0;
    }

    /// The end of a sample at which the model had no finite answer: time goes on, the estimate begins anew.
    pub(crate) fn lose(&mut self) {
        self.begin();
        self.samples = self.samples.min(MOST_SAMPLES) + 1;
    }

    fn begin(&mut self) {
        self.x.copy_from_slice(&self.start);
        self.s.fill(0.0);
        let nx = self.nx();
        for (i, deviation) in self.initial.iter().enumerate() {
            self.s[i * nx + i] = *deviation;
        }
        self.u.fill(0.0);
        self.goes_on = false;
    }

    pub(crate) fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
        visitor.reals("estimated state", &mut self.x);
        visitor.reals("factor of its covariance", &mut self.s);
        visitor.reals("last inputs", &mut self.u);
        let mut counts = [self.samples, u64::from(self.goes_on)];
        visitor.counts("samples of the filter, goes on", &mut counts);
        (self.samples, self.goes_on) = (counts[0], counts[1] != 0);
    }

    /// Time update: the covariance of the propagated deviations and the process noise.
    pub(crate) fn predict(&mut self, deviations: &Deviations) {
        let (nx, m) = (self.nx(), deviations.columns);
        let columns = m + nx;
        let array = &mut self.work[..nx * columns];
        for (i, row) in array.chunks_exact_mut(columns).enumerate() {
            row[..m].copy_from_slice(&deviations.x[i * m..(i + 1) * m]);
            row[m..].fill(0.0);
            row[m + i] = self.process[i];
        }
        triangularise(array, columns);
        for (to, row) in self.s.chunks_exact_mut(nx.max(1)).zip(array.chunks_exact(columns)) {
            to.copy_from_slice(&row[..nx]);
        }
    }

    /// Measurement update with the innovation, and the end of the sample. Without a finite result the
    /// estimate begins anew.
    pub(crate) fn update(&mut self, deviations: &Deviations, innovation: &[f64], u: &[f64]) {
        let (nx, ny, m) = (self.nx(), innovation.len(), deviations.columns);
        let columns = ny + m;
        let array = &mut self.work[..(ny + nx) * columns];
        for (i, row) in array.chunks_exact_mut(columns).enumerate() {
            row[..ny].fill(0.0);
            if i < ny {
                row[i] = self.output[i];
                row[ny..].copy_from_slice(&deviations.y[i * m..(i + 1) * m]);
            } else {
                row[ny..].copy_from_slice(&deviations.x[(i - ny) * m..(i - ny + 1) * m]);
            }
        }
        triangularise(array, columns);
        self.z.copy_from_slice(innovation);
        solve_lower(array, columns, &mut self.z);
        for (i, row) in array.chunks_exact(columns).skip(ny).enumerate() {
            self.x[i] += fd_numeric::dot(&row[..ny], &self.z);
            self.s[i * nx..(i + 1) * nx].copy_from_slice(&row[ny..ny + nx]);
        }
        if self.x.iter().chain(&self.s).all(|value| value.is_finite()) {
            self.u.copy_from_slice(u);
            self.samples = self.samples.min(MOST_SAMPLES) + 1;
            self.goes_on = true;
        } else {
            self.lose();
        }
    }
}
