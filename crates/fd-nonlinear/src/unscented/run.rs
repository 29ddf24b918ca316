//! Running the unscented Kalman filter.

use fd_core::{
    Frame, IoDims, StateVisitor,
    stage::{ResidualGenerator, Stage},
};

use crate::{
    gaussian::{Deviations, Estimate, GaussianFilter},
    model::StateEquations,
    noise::NoisyModel,
};

/// A running unscented Kalman filter; its residual is the innovation.
#[derive(Clone, Debug)]
pub struct UnscentedKalman {
    equations: Box<dyn StateEquations>,
    io: IoDims,
    estimate: Estimate,
    deviations: Deviations,
    /// Distance of the points in spreads, `√(n + κ)`.
    reach: f64,
    /// Weight of the centre, and of each other point.
    weights: [f64; 2],
    asked: Vec<f64>,
    mean: Vec<f64>,
}

impl UnscentedKalman {
    pub(super) fn new(model: &NoisyModel, kappa: f64) -> Self {
        let (nx, io) = (model.nx(), model.io());
        let points = 2 * nx + 1;
        let all = nx as f64 + kappa;
        Self {
            equations: model.equations(),
            io,
            estimate: Estimate::new(model, points),
            deviations: Deviations::new(nx, io.ny, points),
            reach: all.sqrt(),
            weights: [kappa / all, 0.5 / all],
            asked: vec![0.0; nx],
            mean: vec![0.0; nx.max(io.ny)],
        }
    }

    /// Estimate of the state from all samples so far.
    #[must_use]
    pub fn state(&self) -> &[f64] {
        &self.estimate.x
    }
}

impl GaussianFilter for UnscentedKalman {
    fn predict(&mut self, u: &[f64]) -> bool {
        let Self { equations, estimate, deviations, reach, weights, asked, mean, .. } = self;
        let (sample, Some(before)) = estimate.at() else { return true };
        let (nx, points) = (estimate.nx(), deviations.columns);
        let mean = &mut mean[..nx];
        for point in 0..points {
            place(estimate, *reach, point, asked);
            // The place of the mean is free until all points are there.
            equations.advance(sample - 1, asked, before, u, mean);
            (0..nx).for_each(|i| deviations.x[i * points + point] = mean[i]);
        }
        centre(&mut deviations.x, *weights, mean);
        let is_finite = mean.iter().chain(&deviations.x).all(|value| value.is_finite());
        if is_finite {
            estimate.x.copy_from_slice(mean);
            estimate.predict(deviations);
        }
        is_finite
    }

    fn innovate(&mut self, frame: Frame<'_, f64>, r: &mut [f64]) -> bool {
        let Self { equations, estimate, deviations, reach, weights, asked, mean, io } = self;
        let (nx, ny, points) = (estimate.nx(), io.ny, deviations.columns);
        let (sample, _) = estimate.at();
        for point in 0..points {
            place(estimate, *reach, point, asked);
            equations.output(sample, asked, frame.u(), &mut mean[..ny]);
            (0..ny).for_each(|i| deviations.y[i * points + point] = mean[i]);
            (0..nx).for_each(|i| deviations.x[i * points + point] = asked[i]);
        }
        centre(&mut deviations.x, *weights, &mut mean[..nx]);
        centre(&mut deviations.y, *weights, &mut mean[..ny]);
        for ((r, y), mean) in r.iter_mut().zip(frame.y()).zip(&*mean) {
            *r = y - mean;
        }
        r.iter().chain(&deviations.y).all(|value| value.is_finite())
    }

    fn carried(&mut self) -> (&mut Estimate, &Deviations) {
        (&mut self.estimate, &self.deviations)
    }
}

/// Point number `point`: the centre, then one on either side along each column of the factor.
fn place(estimate: &Estimate, reach: f64, point: usize, to: &mut [f64]) {
    let nx = estimate.nx();
    to.copy_from_slice(&estimate.x);
    if let Some(column) = point.checked_sub(1) {
        let distance = if column < nx { reach } else { -reach };
        for (to, row) in to.iter_mut().zip(estimate.s.chunks_exact(nx)) {
            *to += distance * row[column % nx];
        }
    }
}

/// Takes the weighted mean of each row, and leaves deviations from it times the root of their weight.
fn centre(rows: &mut [f64], [first, other]: [f64; 2], mean: &mut [f64]) {
    let points = rows.len() / mean.len().max(1);
    for (row, mean) in rows.chunks_exact_mut(points.max(1)).zip(mean) {
        *mean = first * row[0] + other * row[1..].iter().sum::<f64>();
        row[0] = first.sqrt() * (row[0] - *mean);
        row[1..].iter_mut().for_each(|value| *value = other.sqrt() * (*value - *mean));
    }
}

impl Stage for UnscentedKalman {
    fn reset(&mut self) {
        self.estimate.restart();
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
        self.estimate.visit_state(visitor);
    }
}

impl ResidualGenerator for UnscentedKalman {
    fn io(&self) -> IoDims {
        self.io
    }

    fn residual_len(&self) -> usize {
        self.io.ny
    }

    fn step(&mut self, frame: Frame<'_, f64>, r: &mut [f64]) {
        self.filter(frame, r);
    }
}
