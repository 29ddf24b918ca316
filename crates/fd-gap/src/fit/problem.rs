//! A simulator against logs, as a sum of squares.

use std::{ops::Range, sync::Arc};

use super::{
    error::FitError,
    layout::{Layout, LeastSquares, Linearization},
    levenberg::Minimum,
    plan::{Plan, Segment},
    variable::Variable,
    weights::Weights,
};
use crate::simulate::{Outcome, Run, Simulator};

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
    /// Nominal parameters of the simulator.
    theta: Vec<f64>,
    /// Nominal initial states.
    initial: Vec<f64>,
    /// Where shared unknowns are among the parameters, and own ones among the states.
    shared_places: Vec<usize>,
    own_places: Vec<usize>,
    /// Length of the longest segment.
    longest: usize,
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
            initial,
            shared_places,
            own_places,
            longest,
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

    /// Parameters of the simulator.
    fn parameters(&self, z: &[f64]) -> Vec<f64> {
        let mut theta = self.theta.clone();
        let variables = self.plan.shared.iter().chain(&self.effects);
        for ((variable, &place), z) in variables.zip(&self.shared_places).zip(z) {
            theta[place] = variable.value(*z);
        }
        theta
    }

    /// Simulates a segment at several places side by side, and says of each whether its outputs
    /// are finite.
    fn simulate(&mut self, s: usize, places: &[&[f64]], y: &mut [Vec<f64>]) -> Vec<bool> {
        let Segment { log, from, to } = self.plan.segments[s];
        let log = &self.plan.logs[log];
        let settings: Vec<_> =
            places.iter().map(|z| [self.parameters(z), self.start_of(s, z)]).collect();
        let pairs = settings.iter().zip(y);
        let mut runs: Vec<Run<'_>> = pairs
            .map(|([theta, x0], y)| Run::new(theta, x0, &mut y[..(to - from) * log.ny]))
            .collect();
        // The input after the segment, for simulators that interpolate.
        let u = &log.u[from * log.nu..(to + 1).min(log.samples) * log.nu];
        self.simulator.simulate_many(from as u64, u, &mut runs);
        runs.iter().map(|run| run.outcome == Outcome::Complete).collect()
    }

    /// Weighted residuals of a segment, and before them, if wanted, the errors in units of sigma.
    fn weigh(&self, s: usize, y: &[f64], r: &mut [f64], mut raw: Option<&mut [f64]>) {
        let Segment { log, from, to } = self.plan.segments[s];
        let log = &self.plan.logs[log];
        let rows = self.layout.segments[s].clone();
        let mut error = vec![0.0; to - from];
        for c in 0..log.ny {
            let measured = log.y[from * log.ny..].iter().skip(c).step_by(log.ny);
            let simulated = y.iter().skip(c).step_by(log.ny);
            let sigma = self.weights.sigma[c];
            for ((e, y), m) in error.iter_mut().zip(simulated).zip(measured) {
                *e = (y - m) / sigma;
            }
            let rows = rows.start + c * error.len()..rows.start + (c + 1) * error.len();
            if let Some(raw) = raw.as_deref_mut() {
                raw[rows.clone()].copy_from_slice(&error);
            }
            let colour = &self.weights.colour[c];
            if colour.order() == 0 {
                // White already: only holes have to be filled.
                let seen = error.iter().map(|e| if e.is_finite() { *e } else { 0.0 });
                r[rows].iter_mut().zip(seen).for_each(|(r, e)| *r = e);
            } else {
                colour.whiten(&error, &mut r[rows]);
            }
        }
    }

    /// Weighted residuals at several places, simulated side by side; `None` where they are not
    /// finite.
    fn compare(&mut self, places: &[Vec<f64>]) -> Vec<Option<Vec<f64>>> {
        self.simulations += places.len();
        let ny = self.weights.sigma.len();
        let mut y = vec![vec![0.0; self.longest * ny]; places.len()];
        let mut all = vec![Some(vec![0.0; self.layout.residuals()]); places.len()];
        for s in 0..self.layout.segments.len() {
            let is_finite = |i: &usize| all[*i].is_some();
            let left: Vec<usize> = (0..places.len()).filter(is_finite).collect();
            let now: Vec<&[f64]> = left.iter().map(|&i| places[i].as_slice()).collect();
            let complete = self.simulate(s, &now, &mut y[..left.len()]);
            for ((i, is_complete), y) in left.into_iter().zip(complete).zip(&y) {
                match &mut all[i] {
                    Some(r) if is_complete => self.weigh(s, y, r, None),
                    diverged => *diverged = None,
                }
            }
        }
        for r in &mut all {
            r.take_if(|r| !r.iter().all(|value| value.is_finite()));
        }
        all
    }

    /// The step of a difference: forward, unless that leaves the box.
    fn step(&self, z: &[f64], column: usize) -> f64 {
        let is_effect = (self.plan.shared.len()..self.layout.shared).contains(&column);
        let size = if is_effect { EFFECT_STEP } else { NUISANCE_STEP };
        let is_inside = |i: usize| z[i] + size <= self.bounds[i][1];
        if self.unknowns(column).all(is_inside) { size } else { -size }
    }

    /// The unknowns of a column: those of all segments at once, for an own unknown moves nothing
    /// but its own segment.
    fn unknowns(&self, column: usize) -> impl Iterator<Item = usize> + use<> {
        let Layout { shared, own, .. } = self.layout;
        let count = if column < shared { 1 } else { self.layout.segments.len() };
        (0..count).map(move |s| column + s * own)
    }

    fn moved(&self, z: &[f64], column: usize, step: f64) -> Vec<f64> {
        let mut moved = z.to_vec();
        for i in self.unknowns(column) {
            moved[i] = z[i] + step;
        }
        moved
    }

    /// Errors (simulated less measured) in units of sigma, not whitened, NaN where nothing was
    /// measured: per output, one signal per segment. `None` when a simulation diverges.
    #[must_use]
    pub fn errors(&mut self, z: &[f64]) -> Option<Vec<Vec<Vec<f64>>>> {
        self.simulations += 1;
        let mut r = vec![0.0; self.layout.residuals()];
        let mut raw = r.clone();
        for s in 0..self.layout.segments.len() {
            let y = self.segment_outputs(s, z)?;
            self.weigh(s, &y, &mut r, Some(&mut raw));
        }
        let ny = self.weights.sigma.len();
        let rows = |c: usize, rows: &Range<usize>| {
            let length = rows.len() / ny;
            raw[rows.start + c * length..rows.start + (c + 1) * length].to_vec()
        };
        let signals = |c: usize| self.layout.segments.iter().map(|s| rows(c, s)).collect();
        r.iter().all(|value| value.is_finite()).then(|| (0..ny).map(signals).collect())
    }

    /// The logs of the plan with simulated outputs in place of the measured ones; holes stay.
    #[must_use]
    pub fn simulated(&mut self, z: &[f64]) -> Option<Vec<super::Log>> {
        let mut logs = self.plan.logs.clone();
        for s in 0..self.layout.segments.len() {
            let y = self.segment_outputs(s, z)?;
            let Segment { log, from, to } = self.plan.segments[s];
            let log = &mut logs[log];
            for (m, y) in log.y[from * log.ny..to * log.ny].iter_mut().zip(&y) {
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
        let logs = self.plan.logs.iter();
        let mut outputs: Vec<Vec<f64>> = logs.map(|log| vec![f64::NAN; log.y.len()]).collect();
        for s in 0..self.layout.segments.len() {
            let y = self.segment_outputs(s, z)?;
            let Segment { log, from, .. } = self.plan.segments[s];
            let first = from * self.plan.logs[log].ny;
            outputs[log][first..first + y.len()].copy_from_slice(&y);
        }
        Some(outputs)
    }

    /// Simulated outputs of a segment; `None` when it diverges.
    fn segment_outputs(&mut self, s: usize, z: &[f64]) -> Option<Vec<f64>> {
        let mut y = [vec![0.0; self.layout.segments[s].len()]];
        self.simulate(s, &[z], &mut y)[0].then(|| std::mem::take(&mut y[0]))
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
        let found = self.compare(&[z.to_vec()]).pop().flatten();
        if let Some(found) = &found {
            r.copy_from_slice(found);
        }
        found.is_some()
    }

    fn residuals_of_all(&mut self, places: &[Vec<f64>]) -> Vec<Option<Vec<f64>>> {
        self.compare(places)
    }

    fn slopes(&mut self, z: &[f64], _r: &[f64], columns: Range<usize>, slopes: &mut [Vec<f64>]) {
        let mut found = self.linearize(&[z.to_vec()], columns.clone());
        if let Some(there) = found.pop().flatten() {
            slopes[columns].iter_mut().zip(there.slopes).for_each(|(to, slope)| *to = slope);
        }
    }

    fn linearize(
        &mut self,
        places: &[Vec<f64>],
        columns: Range<usize>,
    ) -> Vec<Option<Linearization>> {
        let steps: Vec<Vec<f64>> =
            places.iter().map(|z| columns.clone().map(|c| self.step(z, c)).collect()).collect();
        let mut batch = Vec::with_capacity(places.len() * (1 + columns.len()));
        for (z, steps) in places.iter().zip(&steps) {
            batch.push(z.clone());
            batch.extend(columns.clone().zip(steps).map(|(c, step)| self.moved(z, c, *step)));
        }
        let mut found = self.compare(&batch).into_iter();
        let mut all = Vec::with_capacity(places.len());
        // Where the simulator does not like this direction, the other one is tried.
        let mut again: Vec<(usize, usize)> = Vec::new();
        for (p, steps) in steps.iter().enumerate() {
            let r = found.next().flatten();
            let trials: Vec<Option<Vec<f64>>> = found.by_ref().take(columns.len()).collect();
            all.push(r.map(|r| {
                let slope = |(i, trial): (usize, Option<Vec<f64>>)| {
                    let Some(trial) = trial else {
                        again.push((p, i));
                        return vec![0.0; r.len()];
                    };
                    difference(trial, &r, steps[i])
                };
                let slopes = trials.into_iter().enumerate().map(slope).collect();
                Linearization { r, slopes }
            }));
        }
        let back =
            |(p, i): &(usize, usize)| self.moved(&places[*p], columns.start + i, -steps[*p][*i]);
        let batch: Vec<Vec<f64>> = again.iter().map(back).collect();
        for ((p, i), trial) in again.into_iter().zip(self.compare(&batch)) {
            if let (Some(there), Some(trial)) = (&mut all[p], trial) {
                there.slopes[i] = difference(trial, &there.r, -steps[p][i]);
            }
        }
        all
    }
}

/// The slope from `r` to what was found a step away.
fn difference(mut trial: Vec<f64>, r: &[f64], step: f64) -> Vec<f64> {
    trial.iter_mut().zip(r).for_each(|(trial, r)| *trial = (*trial - r) / step);
    trial
}
