//! Running the bootstrap filter.

use fd_core::{
    Frame, IoDims, StateVisitor,
    stage::{ResidualGenerator, Stage},
};
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::{
    gaussian::MOST_SAMPLES,
    model::StateEquations,
    noise::{Noise, NoisyModel},
};

/// Spreads the numbers of samples over the seeds; odd, and not the constant that seeding itself uses.
const SPREAD: u64 = 0xD1B5_4A32_D192_ED03;

/// A running bootstrap filter; its residual is the innovation.
#[derive(Clone, Debug)]
pub struct BootstrapFilter {
    equations: Box<dyn StateEquations>,
    io: IoDims,
    start: Vec<f64>,
    noise: Noise,
    seed: u64,
    /// States of the particles, row by row, and their weights.
    particles: Vec<f64>,
    weights: Vec<f64>,
    /// Inputs of the sample before.
    u: Vec<f64>,
    samples: u64,
    goes_on: bool,
    /// Scratch: particles drawn anew, and the outputs of all.
    drawn: Vec<f64>,
    outputs: Vec<f64>,
}

impl BootstrapFilter {
    pub(super) fn new(model: &NoisyModel, particles: usize, seed: u64) -> Self {
        let (nx, io) = (model.nx(), model.io());
        Self {
            equations: model.equations(),
            io,
            start: model.start().to_vec(),
            noise: model.noise().clone(),
            seed,
            particles: vec![0.0; particles * nx],
            weights: vec![0.0; particles],
            u: vec![0.0; io.nu],
            samples: 0,
            goes_on: false,
            drawn: vec![0.0; particles * nx],
            outputs: vec![0.0; particles * io.ny],
        }
    }

    /// Writes the mean of the state after all samples so far; zeros before the first.
    ///
    /// # Panics
    ///
    /// Panics when there is not one place per state.
    pub fn mean(&self, x: &mut [f64]) {
        assert_eq!(x.len(), self.start.len(), "one place per state");
        x.fill(0.0);
        for (particle, weight) in self.particles.chunks_exact(x.len().max(1)).zip(&self.weights) {
            x.iter_mut().zip(particle).for_each(|(x, value)| *x += weight * value);
        }
    }

    /// The particles at this sample, before its outputs: drawn at the start, or moved on with noise.
    fn propagate(&mut self, sample: u64, u: &[f64], random: &mut Xoshiro256PlusPlus) {
        let nx = self.start.len().max(1);
        let (Noise { process, initial, .. }, goes_on) = (&self.noise, self.goes_on && 0 < sample);
        if !goes_on {
            let equal = (self.weights.len() as f64).recip();
            self.weights.fill(equal);
        }
        let rows = self.particles.chunks_exact_mut(nx).zip(self.drawn.chunks_exact_mut(nx));
        for (particle, next) in rows {
            if goes_on {
                self.equations.advance(sample - 1, particle, &self.u, u, next);
            } else {
                next.copy_from_slice(&self.start);
            }
            let deviations = if goes_on { process } else { initial };
            for ((x, next), deviation) in particle.iter_mut().zip(&*next).zip(deviations) {
                *x = next + deviation * random.sample::<f64, _>(StandardNormal);
            }
        }
    }

    /// Computes all outputs and their mean. Particles that the model has no finite answer for weigh nothing;
    /// `false` when that is all of them.
    fn foretell(&mut self, sample: u64, u: &[f64], mean: &mut [f64]) -> bool {
        let (nx, ny) = (self.start.len().max(1), self.io.ny.max(1));
        mean.fill(0.0);
        let rows = self.particles.chunks_exact_mut(nx).zip(self.outputs.chunks_exact_mut(ny));
        let mut total = 0.0;
        for ((particle, y), weight) in rows.zip(&mut self.weights) {
            self.equations.output(sample, particle, u, y);
            if !particle.iter().chain(&*y).all(|value| value.is_finite()) {
                *weight = 0.0;
                // Nobody asks for them any more; a weight of zero times NaN would show.
                particle.copy_from_slice(&self.start);
                y.fill(0.0);
            }
            total += *weight;
            mean.iter_mut().zip(&*y).for_each(|(mean, y)| *mean += *weight * y);
        }
        for mean in &mut *mean {
            *mean /= total;
        }
        total > 0.0 && mean.iter().all(|mean| mean.is_finite())
    }

    /// Weighs the particles by how likely they make the measured outputs.
    fn weigh(&mut self, y: &[f64]) {
        let ny = self.io.ny.max(1);
        let mut best = f64::NEG_INFINITY;
        for (outputs, weight) in self.outputs.chunks_exact_mut(ny).zip(&self.weights) {
            let distance: f64 = (outputs.iter().zip(y).zip(&self.noise.output))
                .map(|((expected, y), deviation)| ((y - expected) / deviation).powi(2))
                .sum();
            outputs[0] = -0.5 * distance;
            if *weight > 0.0 {
                best = best.max(outputs[0]);
            }
        }
        // Relative to the best, so that a sample that nobody expected does not leave all with nothing.
        let mut total = 0.0;
        for (outputs, weight) in self.outputs.chunks_exact(ny).zip(&mut self.weights) {
            if best.is_finite() {
                *weight *= (outputs[0] - best).exp();
            }
            total += *weight;
        }
        self.weights.iter_mut().for_each(|weight| *weight /= total);
    }

    /// Draws all particles anew when fewer than half of them count.
    fn resample(&mut self, random: &mut Xoshiro256PlusPlus) {
        let (nx, count) = (self.start.len().max(1), self.weights.len());
        let offset: f64 = random.random();
        let effective = fd_numeric::dot(&self.weights, &self.weights).recip();
        if effective >= 0.5 * count as f64 {
            return;
        }
        let (mut from, mut reached) = (0, self.weights[0]);
        for (i, drawn) in self.drawn.chunks_exact_mut(nx).enumerate() {
            let wanted = (i as f64 + offset) / count as f64;
            while reached < wanted && from + 1 < count {
                from += 1;
                reached += self.weights[from];
            }
            drawn.copy_from_slice(&self.particles[from * nx..(from + 1) * nx]);
        }
        std::mem::swap(&mut self.particles, &mut self.drawn);
        self.weights.fill((count as f64).recip());
    }

    fn lose(&mut self) {
        self.particles.fill(0.0);
        self.weights.fill(0.0);
        self.u.fill(0.0);
        self.goes_on = false;
    }
}

impl Stage for BootstrapFilter {
    fn reset(&mut self) {
        self.lose();
        self.samples = 0;
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
        visitor.reals("particles", &mut self.particles);
        visitor.reals("weights of the particles", &mut self.weights);
        visitor.reals("last inputs", &mut self.u);
        let mut counts = [self.samples, u64::from(self.goes_on)];
        visitor.counts("samples of the filter, goes on", &mut counts);
        (self.samples, self.goes_on) = (counts[0], counts[1] != 0);
    }
}

impl ResidualGenerator for BootstrapFilter {
    fn io(&self) -> IoDims {
        self.io
    }

    fn residual_len(&self) -> usize {
        self.io.ny
    }

    fn step(&mut self, frame: Frame<'_, f64>, r: &mut [f64]) {
        let sample = self.samples.min(MOST_SAMPLES);
        let stream = self.seed ^ sample.wrapping_mul(SPREAD);
        let mut random = Xoshiro256PlusPlus::seed_from_u64(stream);
        self.propagate(sample, frame.u(), &mut random);
        if self.foretell(sample, frame.u(), r) {
            r.iter_mut().zip(frame.y()).for_each(|(r, y)| *r = y - *r);
            self.weigh(frame.y());
            self.resample(&mut random);
            self.u.copy_from_slice(frame.u());
            self.goes_on = self.weights.iter().all(|weight| weight.is_finite());
        } else {
            r.fill(f64::NAN);
            self.goes_on = false;
        }
        if !self.goes_on {
            self.lose();
        }
        self.samples = sample + 1;
    }
}
