//! A simulated log whose cause is known.

use fd_model::Record;
use fd_sim::model::Model;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::{
    diagnose::{Case, Diagnosis, Start},
    fit::Variable,
    locate::bench::{Bench, Rows, settled},
    quality::Autoregression,
};

/// What all replicas of a case have in common.
#[derive(Debug)]
pub(super) struct Source<'a> {
    case: &'a Case<'a>,
    bench: &'a Bench,
    /// Standard deviation of the noise of each output, in its unit.
    noise: Vec<f64>,
    /// Coefficients of its autoregression, the latest sample first, and the spread of its
    /// innovations.
    colour: Vec<(Vec<f64>, f64)>,
}

impl<'a> Source<'a> {
    pub(super) fn new(case: &'a Case<'a>, diagnosis: &Diagnosis, bench: &'a Bench) -> Self {
        let left = bench.residuals(&diagnosis.best.outputs);
        let colour = |signals: &Rows| {
            let signals: Vec<&[f64]> = signals.iter().map(Vec::as_slice).collect();
            let highest = if diagnosis.is_coloured { Autoregression::HIGHEST_ORDER } else { 0 };
            coefficients(&Autoregression::fit(&signals, highest))
        };
        let colour = left.iter().map(colour).collect();
        let noise = diagnosis.sigma.iter().zip(&diagnosis.floor).map(|(s, f)| s * f).collect();
        Self { case, bench, noise, colour }
    }

    /// Logs of a model with the logged inputs: uncertain parameters drawn from their priors about
    /// the nominal values, noise as it was found, holes where they were. `None` when the model
    /// diverges with these parameters.
    pub(super) fn draw(&self, model: &Model, starts: &[Start], seed: u64) -> Option<Vec<Record>> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut simulator = self.case.nominal.patched(model, self.bench.simulator.ts()).ok()?;
        let mut theta = settled(&*simulator);
        for parameter in &self.case.nominal.model().parameters {
            let place = simulator.parameters().iter().position(|p| p.name == parameter.name);
            if let (Some(place), Some(variable)) = (place, Variable::nuisance(parameter)) {
                let drawn = variable.start + variable.scale * normal(&mut random);
                theta[place] = drawn.clamp(variable.low, variable.high);
            }
        }
        // One run per log: where a window starts is for the diagnosis to find out.
        let mut whole = self.bench.clone();
        whole.segments.retain(|segment| segment.from == 0);
        for segment in &mut whole.segments {
            segment.to = whole.logs[segment.log].samples;
        }
        let starts: Vec<Start> = starts.iter().filter(|start| start.from == 0).cloned().collect();
        let (outputs, _) = whole.run(&mut *simulator, &theta, &starts, &Vec::new())?;
        let records: Result<Vec<Record>, _> = (outputs.into_iter().enumerate())
            .map(|(l, outputs)| self.noisy(l, outputs, &mut random))
            .collect();
        records.ok()
    }

    fn noisy(
        &self,
        l: usize,
        mut y: Vec<f64>,
        random: &mut Xoshiro256PlusPlus,
    ) -> Result<Record, fd_model::ModelError> {
        let log = &self.bench.logs[l];
        for (c, (noise, (past, spread))) in self.noise.iter().zip(&self.colour).enumerate() {
            let warm_up = 20 * past.len();
            let mut w: Vec<f64> = Vec::with_capacity(warm_up + log.samples);
            for _ in 0..warm_up + log.samples {
                let predicted: f64 = past.iter().zip(w.iter().rev()).map(|(a, w)| a * w).sum();
                w.push(predicted + spread * normal(random));
            }
            for (k, w) in w[warm_up..].iter().enumerate() {
                let value = &mut y[k * log.ny + c];
                let is_there = log.y[k * log.ny + c].is_finite();
                *value = if is_there { *value + noise * w } else { f64::NAN };
            }
        }
        let (inputs, outputs) = (self.bench.simulator.inputs(), self.bench.simulator.outputs());
        let ts = self.bench.simulator.ts();
        Record::new(inputs.to_vec(), outputs.to_vec(), log.u.clone(), y, ts)
    }
}

/// Coefficients of an autoregression and spread of its innovations, out of its response to an
/// impulse that comes after enough zeros: `1/g, −a₁/g, …`.
fn coefficients(colour: &Autoregression) -> (Vec<f64>, f64) {
    let order = colour.order();
    let mut impulse = vec![0.0; 2 * order + 1];
    impulse[order] = 1.0;
    let mut response = impulse.clone();
    colour.whiten(&impulse, &mut response);
    let spread = colour.innovation();
    (response[order + 1..].iter().map(|e| -e * spread).collect(), spread)
}

/// A standard normal number (Box and Muller 1958).
fn normal(random: &mut Xoshiro256PlusPlus) -> f64 {
    let (a, b) = (random.random::<f64>(), random.random::<f64>());
    (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coloured_noise_has_the_colour_that_was_found() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        let mut w = vec![0.0; 5000];
        for k in 2..w.len() {
            w[k] = 1.2 * w[k - 1] - 0.5 * w[k - 2] + normal(&mut random);
        }
        let colour = Autoregression::fit(&[&w], Autoregression::HIGHEST_ORDER);
        let (past, spread) = coefficients(&colour);
        // Standard errors are about sqrt((1 - 0.5²)/5000) = 0.012.
        assert!((past[0] - 1.2).abs() < 0.05 && (past[1] + 0.5).abs() < 0.05, "{past:?}");
        // Noise made of given innovations is whitened back to them.
        let e: Vec<f64> = (0..50).map(|_| normal(&mut random)).collect();
        let mut made = w[..20].to_vec();
        for e in &e {
            let predicted: f64 = past.iter().zip(made.iter().rev()).map(|(a, w)| a * w).sum();
            made.push(predicted + spread * e);
        }
        let mut whitened = vec![0.0; made.len()];
        colour.whiten(&made, &mut whitened);
        // A few products of rounding 1e-16 each, divided by the spread.
        assert!(e.iter().zip(&whitened[20..]).all(|(a, b)| (a - b).abs() < 1e-12 / spread));
    }
}
