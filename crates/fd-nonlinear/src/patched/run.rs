//! Running simulations side by side, and following their parameters.

use fd_core::{
    Frame, IoDims, StateVisitor,
    stage::{ResidualGenerator, Stage},
};
use fd_model::Scaling;
use fd_sim::simulate::Simulator;

use super::{
    design::PatchedDesign,
    learn::Learned,
    track::{Axis, Track},
};
use crate::{gaussian::MOST_SAMPLES, scaled::to_units};

/// A running simulation with tracked parameters; its residual is measured minus simulated output.
#[derive(Clone, Debug)]
pub struct Patched {
    io: IoDims,
    scaling: Scaling,
    /// The simulation, then one with each tracked parameter shifted, with the values that each is started with.
    simulators: Vec<Box<dyn Simulator>>,
    thetas: Vec<Vec<f64>>,
    start: Vec<f64>,
    axes: Vec<Axis>,
    learned: Option<Learned>,
    smoothing: f64,
    suspicion: f64,
    samples: u64,
    track: Track,
    smoothed: Vec<f64>,
    u: Vec<f64>,
    /// Outputs of all simulations, row by row, and the slopes of one output.
    outputs: Vec<f64>,
    slopes: Vec<f64>,
    /// Distances before this sample.
    before: Vec<f64>,
}

impl PatchedDesign {
    /// Moves the residual to run time, at its start.
    #[must_use]
    pub fn freeze(&self) -> Patched {
        Patched::new(self)
    }
}

impl Patched {
    pub(super) fn new(design: &PatchedDesign) -> Self {
        let (io, count) = (design.io(), 1 + design.tracked.len());
        let mut thetas = vec![design.theta.clone(); count];
        for (theta, axis) in thetas[1..].iter_mut().zip(&design.tracked) {
            theta[axis.parameter] += axis.shift;
        }
        let mut made = Self {
            io,
            scaling: design.scaling.clone(),
            simulators: vec![design.simulator.boxed(); count],
            thetas,
            start: design.start.clone(),
            axes: design.tracked.clone(),
            learned: design.learned.clone(),
            smoothing: design.smoothing,
            suspicion: design.suspicion,
            samples: 0,
            track: Track::new(&design.tracked),
            smoothed: vec![0.0; io.ny],
            u: vec![0.0; io.nu],
            outputs: vec![0.0; count * io.ny],
            slopes: vec![0.0; count - 1],
            before: vec![0.0; count - 1],
        };
        made.begin(0);
        made
    }

    /// The values of the tracked parameters now.
    pub fn tracked(&self) -> impl Iterator<Item = f64> + '_ {
        let values = self.axes.iter().zip(&self.track.distance);
        values.map(|(axis, distance)| self.thetas[0][axis.parameter] + distance)
    }

    /// Whether a fault is suspected, so that nothing is learned.
    #[must_use]
    pub fn is_frozen(&self) -> bool {
        self.learned.as_ref().is_some_and(|learned| {
            let pairs = self.smoothed.iter().zip(&learned.largest);
            pairs.into_iter().any(|(z, largest)| self.suspicion * largest < z.abs())
        })
    }

    fn begin(&mut self, sample: u64) {
        for (simulator, theta) in self.simulators.iter_mut().zip(&self.thetas) {
            simulator.start(theta, &self.start, sample);
        }
    }

    /// Writes the slopes of an output, in the signals of the pipeline.
    fn slope(&mut self, output: usize) {
        let ny = self.io.ny;
        let scale = self.scaling.outputs[output].scale.unwrap_or(1.0);
        let nominal = self.outputs[output];
        for (i, (slope, axis)) in self.slopes.iter_mut().zip(&self.axes).enumerate() {
            *slope = (self.outputs[(i + 1) * ny + output] - nominal) / (axis.shift * scale);
        }
    }

    /// Follows the parameters, unless a fault is suspected.
    fn follow(&mut self, r: &[f64]) {
        let Some(learned) = &self.learned else { return };
        for ((z, r), deviation) in self.smoothed.iter_mut().zip(r).zip(&learned.deviation) {
            *z += self.smoothing * (r / deviation - *z);
        }
        if self.axes.is_empty() || self.is_frozen() {
            return;
        }
        self.before.copy_from_slice(&self.track.distance);
        self.track.walk();
        for (output, r) in r.iter().enumerate() {
            self.slope(output);
            // What the outputs before have already explained of this one is no longer left.
            let ways = self.track.distance.iter().zip(&self.before).zip(&self.slopes);
            let explained: f64 = ways.map(|((now, before), slope)| (now - before) * slope).sum();
            let variance = self.learned.as_ref().map_or(f64::INFINITY, |l| l.variance[output]);
            self.track.learn(r - explained, &self.slopes, variance);
        }
    }
}

impl Stage for Patched {
    fn reset(&mut self) {
        self.begin(0);
        self.samples = 0;
        self.track.reset();
        self.smoothed.fill(0.0);
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
        for simulator in &mut self.simulators {
            simulator.visit_memory(visitor);
        }
        self.track.visit_state(visitor);
        visitor.reals("smoothed residual", &mut self.smoothed);
        visitor.counts("samples of the simulation", std::slice::from_mut(&mut self.samples));
    }
}

impl ResidualGenerator for Patched {
    fn io(&self) -> IoDims {
        self.io
    }

    fn residual_len(&self) -> usize {
        self.io.ny
    }

    fn step(&mut self, frame: Frame<'_, f64>, r: &mut [f64]) {
        let ny = self.io.ny;
        to_units(&self.scaling.inputs, frame.u(), &mut self.u);
        self.samples = self.samples.min(MOST_SAMPLES) + 1;
        let rows = self.outputs.chunks_exact_mut(ny.max(1));
        for (simulator, y) in self.simulators.iter_mut().zip(rows) {
            simulator.step(&self.u, &self.u, &[], y);
        }
        for (output, (r, y)) in r.iter_mut().zip(frame.y()).enumerate() {
            self.slope(output);
            let tracked = fd_numeric::dot(&self.slopes, &self.track.distance);
            *r = y - self.scaling.outputs[output].scaled(self.outputs[output]) - tracked;
        }
        if r.iter().all(|r| r.is_finite()) {
            self.follow(r);
        } else {
            // The model has no answer here: it starts anew with the next sample, its parameters as they are.
            r.fill(f64::NAN);
            self.begin(self.samples);
        }
        // Beyond all sense, which only a memory from elsewhere can be.
        if !self.smoothed.iter().chain(&self.track.distance).all(|value| value.is_finite()) {
            self.track.reset();
            self.smoothed.fill(0.0);
        }
    }
}
