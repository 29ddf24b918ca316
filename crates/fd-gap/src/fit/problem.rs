//! A simulator against logs, as a sum of squares.

use std::{ops::Range, sync::Arc};

use super::{
    error::FitError,
    layout::{Layout, LeastSquares},
    levenberg::Minimum,
    plan::Plan,
    variable::Variable,
    weights::Weights,
};
use crate::simulate::Simulator;

/// Step of a forward difference in a nuisance, in scales. Rounding errors of a simulation are
/// below 1e-12 of its values, and a nuisance moves outputs by up to 1e3 sigma per scale.
const NUISANCE_STEP: f64 = 1e-5;
/// Step of a forward difference in a parameter of an effect, in scales: such laws have kinks.
const EFFECT_STEP: f64 = 1e-4;

/// The weighted error of a simulation, as a function of nuisances and parameters of an effect.
#[derive(Clone, Debug)]
pub struct Problem {
    plan: Arc<Plan>,
    simulator: Box<dyn Simulator>,
    weights: Weights,
    effects: Vec<Variable>,
    layout: Layout,
    bounds: Vec<[f64; 2]>,
    prior: Vec<[f64; 2]>,
    /// Nominal parameters of the simulator, and those of the trial.
    theta: Vec<f64>,
    x0: Vec<f64>,
    initial: Vec<f64>,
    /// Where shared unknowns are among the parameters, and own ones among the states.
    shared_places: Vec<usize>,
    own_places: Vec<usize>,
    y: Vec<f64>,
    error: Vec<f64>,
    trial: Vec<f64>,
    simulations: usize,
}

impl Problem {
    /// The problem of a simulator that has the parameters and states of the plan, and possibly an
    /// effect with parameters of its own.
    ///
    /// # Errors
    ///
    /// Returns an error when the simulator lacks one of them.
    pub fn new(
        plan: Arc<Plan>,
        simulator: Box<dyn Simulator>,
        effects: Vec<Variable>,
        weights: Weights,
    ) -> Result<Self, FitError> {
        let missing = |what, name: &str| FitError::Missing { what, name: name.to_owned() };
        let parameter = |variable: &Variable| {
            let place = simulator.parameters().iter().position(|p| p.name == variable.name);
            place.ok_or_else(|| missing("parameter", &variable.name))
        };
        let state = |name: &String| {
            let place = simulator.initial().iter().position(|s| s.channel.name == *name);
            place.ok_or_else(|| missing("state", name))
        };
        let shared: Vec<Variable> = plan.shared.iter().chain(&effects).cloned().collect();
        let shared_places = shared.iter().map(parameter).collect::<Result<Vec<_>, _>>()?;
        let own_places = plan.own_names.iter().map(state).collect::<Result<Vec<_>, _>>()?;
        let mut segments = Vec::with_capacity(plan.segments.len());
        let (mut end, mut longest) = (0, 0);
        let ny = simulator.outputs().len();
        for segment in &plan.segments {
            let length = segment.to - segment.from;
            segments.push(end..end + length * ny);
            end += length * ny;
            longest = longest.max(length);
        }
        let layout = Layout { shared: shared.len(), own: own_places.len(), segments };
        let variables = || shared.iter().chain(plan.own.iter().flatten());
        let initial: Vec<f64> = simulator.initial().iter().map(|state| state.value).collect();
        Ok(Self {
            bounds: variables().map(Variable::range).collect(),
            prior: variables().map(|variable| [0.0, variable.precision()]).collect(),
            theta: simulator.parameters().iter().map(|p| p.value).collect(),
            x0: initial.clone(),
            initial,
            shared_places,
            own_places,
            y: vec![0.0; longest * ny],
            error: vec![0.0; longest],
            trial: vec![0.0; end],
            simulations: 0,
            plan,
            simulator,
            weights,
            effects,
            layout,
        })
    }

    /// What is fitted to what.
    #[must_use]
    pub fn plan(&self) -> &Arc<Plan> {
        &self.plan
    }

    /// Parameters of the effect.
    #[must_use]
    pub fn effects(&self) -> &[Variable] {
        &self.effects
    }

    /// Scale and colour of the noise.
    #[must_use]
    pub fn weights(&self) -> &Weights {
        &self.weights
    }

    /// Sets scale and colour of the noise.
    pub fn set_weights(&mut self, weights: Weights) {
        self.weights = weights;
    }

    /// Simulations of all logs so far.
    #[must_use]
    pub fn simulations(&self) -> usize {
        self.simulations
    }

    /// The simulator.
    #[must_use]
    pub fn simulator(&self) -> &dyn Simulator {
        &*self.simulator
    }

    /// Scaled unknowns from those of the plan (as of the null problem) and values of the effect.
    #[must_use]
    pub fn place(&self, nuisances: &[f64], effects: &[f64]) -> Vec<f64> {
        let (shared, own) = nuisances.split_at(self.plan.shared.len());
        let effects = self.effects.iter().zip(effects).map(|(v, value)| v.scaled(*value));
        shared.iter().copied().chain(effects).chain(own.iter().copied()).collect()
    }

    /// The scaled unknowns of the plan within those of this problem.
    #[must_use]
    pub fn nuisances(&self, z: &[f64]) -> Vec<f64> {
        let shared = self.plan.shared.len();
        z[..shared].iter().chain(&z[self.layout.shared..]).copied().collect()
    }

    /// Values of the parameters of the effect, in their units.
    #[must_use]
    pub fn effect_values(&self, z: &[f64]) -> Vec<f64> {
        let own = &z[self.plan.shared.len()..self.layout.shared];
        self.effects.iter().zip(own).map(|(variable, z)| variable.value(*z)).collect()
    }

    /// Values of all unknowns of the plan, in their units.
    #[must_use]
    pub fn nuisance_values(&self, z: &[f64]) -> Vec<f64> {
        let variables = self.plan.shared.iter().chain(self.plan.own.iter().flatten());
        variables.zip(self.nuisances(z)).map(|(variable, z)| variable.value(z)).collect()
    }

    /// Simulates a segment into `self.y`; `false` when it diverges.
    fn simulate(&mut self, s: usize, z: &[f64]) -> bool {
        let segment = self.plan.segments[s];
        let log = &self.plan.logs[segment.log];
        let variables = self.plan.shared.iter().chain(&self.effects);
        for ((variable, &place), z) in variables.zip(&self.shared_places).zip(z) {
            self.theta[place] = variable.value(*z);
        }
        self.x0.copy_from_slice(&self.initial);
        let own = &z[self.layout.first_own(s)..];
        for ((variable, &place), z) in self.plan.own[s].iter().zip(&self.own_places).zip(own) {
            self.x0[place] = variable.value(*z);
        }
        self.simulator.start(&self.theta, &self.x0, segment.from as u64);
        for (row, k) in self.y.chunks_exact_mut(log.ny).zip(segment.from..segment.to) {
            self.simulator.step(log.input(k), log.input(k + 1), &[], row);
            if row.iter().any(|value| !value.is_finite()) {
                return false;
            }
        }
        true
    }

    /// Weighted residuals, and before them, if wanted, the errors in units of sigma.
    fn compare(&mut self, z: &[f64], r: &mut [f64], mut raw: Option<&mut [f64]>) -> bool {
        self.simulations += 1;
        for s in 0..self.layout.segments.len() {
            if !self.simulate(s, z) {
                return false;
            }
            let segment = self.plan.segments[s];
            let log = &self.plan.logs[segment.log];
            let length = segment.to - segment.from;
            let rows = self.layout.segments[s].clone();
            for c in 0..log.ny {
                let measured = log.y[segment.from * log.ny..].iter().skip(c).step_by(log.ny);
                let simulated = self.y.iter().skip(c).step_by(log.ny);
                let sigma = self.weights.sigma[c];
                let error = &mut self.error[..length];
                for ((e, y), m) in error.iter_mut().zip(simulated).zip(measured) {
                    *e = (y - m) / sigma;
                }
                let rows = rows.start + c * length..rows.start + (c + 1) * length;
                if let Some(raw) = raw.as_deref_mut() {
                    raw[rows.clone()].copy_from_slice(error);
                }
                self.weights.colour[c].whiten(error, &mut r[rows]);
            }
        }
        r.iter().all(|value| value.is_finite())
    }

    /// Errors (simulated less measured) in units of sigma, not whitened, NaN where nothing was
    /// measured: per output, one signal per segment. `None` when a simulation diverges.
    #[must_use]
    pub fn errors(&mut self, z: &[f64]) -> Option<Vec<Vec<Vec<f64>>>> {
        let mut r = vec![0.0; self.layout.residuals()];
        let mut raw = r.clone();
        self.compare(z, &mut r, Some(&mut raw)).then(|| {
            let ny = self.weights.sigma.len();
            let rows = |c: usize, rows: &Range<usize>| {
                let length = rows.len() / ny;
                raw[rows.start + c * length..rows.start + (c + 1) * length].to_vec()
            };
            (0..ny).map(|c| self.layout.segments.iter().map(|s| rows(c, s)).collect()).collect()
        })
    }

    /// The logs of the plan with simulated outputs in place of the measured ones; holes stay.
    #[must_use]
    pub fn simulated(&mut self, z: &[f64]) -> Option<Vec<super::Log>> {
        let mut logs = self.plan.logs.clone();
        for s in 0..self.layout.segments.len() {
            if !self.simulate(s, z) {
                return None;
            }
            let segment = self.plan.segments[s];
            let log = &mut logs[segment.log];
            let measured = log.y[segment.from * log.ny..segment.to * log.ny].iter_mut();
            for (m, y) in measured.zip(&self.y) {
                if m.is_finite() {
                    *m = *y;
                }
            }
        }
        Some(logs)
    }

    /// Simulated outputs of each log of the plan, row by row; `None` when a simulation diverges.
    #[must_use]
    pub fn outputs(&mut self, z: &[f64]) -> Option<Vec<Vec<f64>>> {
        let logs = &self.plan.logs;
        let mut outputs: Vec<Vec<f64>> =
            logs.iter().map(|log| vec![f64::NAN; log.y.len()]).collect();
        for s in 0..self.layout.segments.len() {
            if !self.simulate(s, z) {
                return None;
            }
            let segment = self.plan.segments[s];
            let ny = self.plan.logs[segment.log].ny;
            let (from, to) = (segment.from * ny, segment.to * ny);
            outputs[segment.log][from..to].copy_from_slice(&self.y[..to - from]);
        }
        Some(outputs)
    }

    /// The state at the start of a segment, in the order of the simulator.
    #[must_use]
    pub fn start_of(&self, segment: usize, z: &[f64]) -> Vec<f64> {
        let mut x0 = self.initial.clone();
        let own = &z[self.layout.first_own(segment)..];
        for ((variable, &place), z) in self.plan.own[segment].iter().zip(&self.own_places).zip(own)
        {
            x0[place] = variable.value(*z);
        }
        x0
    }

    /// Standard deviation of each parameter of the effect, in its unit, when noise is `scale`
    /// times as large as the weights say.
    #[must_use]
    pub fn standard_errors(&self, at: &Minimum, scale: f64) -> Option<Vec<f64>> {
        let equations = super::arrow::Arrow::new(
            &self.layout,
            &at.slopes,
            &at.r,
            &self.prior,
            &at.z,
            1.0 / scale,
        );
        let factor = equations.factor()?;
        let first = self.plan.shared.len();
        let deviation = |(i, v): (usize, &Variable)| v.scale * factor.variance(first + i).sqrt();
        Some(self.effects.iter().enumerate().map(deviation).collect())
    }
}

impl LeastSquares for Problem {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn bounds(&self) -> &[[f64; 2]] {
        &self.bounds
    }

    fn prior(&self) -> &[[f64; 2]] {
        &self.prior
    }

    fn residuals(&mut self, z: &[f64], r: &mut [f64]) -> bool {
        self.compare(z, r, None)
    }

    fn slopes(&mut self, z: &[f64], r: &[f64], columns: Range<usize>, slopes: &mut [Vec<f64>]) {
        let shared = self.layout.shared;
        let mut moved = z.to_vec();
        let mut trial = std::mem::take(&mut self.trial);
        for column in columns {
            let is_effect = (self.plan.shared.len()..shared).contains(&column);
            let size = if is_effect { EFFECT_STEP } else { NUISANCE_STEP };
            let places: Vec<usize> = if column < shared {
                vec![column]
            } else {
                // All segments at once: an own unknown moves nothing but its own segment.
                let segments = 0..self.layout.segments.len();
                segments.map(|s| self.layout.first_own(s) + column - shared).collect()
            };
            let slope = &mut slopes[column];
            slope.fill(0.0);
            // The other direction if this one leaves the box or the simulator does not like it.
            let is_inside = places.iter().all(|&i| z[i] + size <= self.bounds[i][1]);
            let order = if is_inside { [size, -size] } else { [-size, size] };
            for step in order {
                for &i in &places {
                    moved[i] = z[i] + step;
                }
                if self.compare(&moved, &mut trial, None) {
                    let differences = trial.iter().zip(r).map(|(t, r)| (t - r) / step);
                    slope.iter_mut().zip(differences).for_each(|(slope, d)| *slope = d);
                    break;
                }
            }
            for &i in &places {
                moved[i] = z[i];
            }
        }
        self.trial = trial;
    }
}
