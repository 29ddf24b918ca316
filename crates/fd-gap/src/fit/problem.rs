//! A simulator against logs, as a sum of squares.

mod circles;
mod signals;
mod slopes;

use std::sync::Arc;

use fd_sim::simulate::{Outcome, Run, Simulator};
use rayon::prelude::*;

use super::{
    arrow::Arrow,
    error::FitError,
    layout::Layout,
    levenberg::{Minimum, Search},
    plan::{Plan, Segment},
    variable::Variable,
    weights::Weights,
};

/// Places that are simulated side by side, and whose residuals are in memory at a time.
pub(crate) const AT_A_TIME: usize = 16;

/// Who simulates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum By {
    Simulator,
    /// What stands in for it where slopes are asked for.
    StandIn,
}

/// The weighted error of a simulation, as a function of nuisances and parameters of an effect.
#[derive(Clone, Debug)]
pub struct Problem {
    plan: Arc<Plan>,
    simulator: Box<dyn Simulator>,
    /// What gives the slopes instead, where runs are dear.
    stand_in: Option<Box<dyn Simulator>>,
    /// Whether it gives everything else as well.
    is_stood_in: bool,
    /// Whether errors on a circle go on beyond half a turn.
    goes_on: bool,
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
        // It knows the fitted logs and no others.
        let stand_in =
            simulator.stand_in().filter(|_| plan.logs.iter().all(|log| log.row.is_some()));
        Ok(Self {
            stand_in,
            is_stood_in: false,
            goes_on: false,
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
    pub(crate) fn parameters(&self, z: &[f64]) -> Vec<f64> {
        let mut theta = self.theta.clone();
        let variables = self.plan.shared.iter().chain(&self.effects);
        for ((variable, &place), z) in variables.zip(&self.shared_places).zip(z) {
            theta[place] = variable.value(*z);
        }
        theta
    }

    /// Simulates a segment at several places side by side, and says of each whether its outputs
    /// are finite.
    fn simulate(&mut self, by: By, s: usize, places: &[&[f64]], y: &mut [Vec<f64>]) -> Vec<bool> {
        let Segment { log, from, to } = self.plan.segments[s];
        let log = &self.plan.logs[log];
        let settings: Vec<_> =
            places.iter().map(|z| [self.parameters(z), self.start_of(s, z)]).collect();
        let pairs = settings.iter().zip(y);
        let mut runs: Vec<Run<'_>> = pairs
            .map(|([theta, x0], y)| Run::new(theta, x0, &mut y[..(to - from) * log.ny]))
            .collect();
        // The input after the segment, for simulators that interpolate.
        let rows = from..(to + 1).min(log.samples);
        let first = (log.first + from) as u64;
        match &mut self.stand_in {
            Some(stand_in) if by == By::StandIn || self.is_stood_in => {
                let u: Vec<f64> = log.rows(rows).collect();
                stand_in.simulate_many(first, &u, &mut runs);
            }
            _ => {
                let u = &log.u[rows.start * log.nu..rows.end * log.nu];
                self.simulator.simulate_many(first, u, &mut runs);
            }
        }
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
            self.compare_output(c, log.circles[c], simulated.zip(measured), &mut error);
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
    fn compare(&mut self, by: By, places: &[Vec<f64>]) -> Vec<Option<Vec<f64>>> {
        if by == By::Simulator && !self.is_stood_in {
            self.simulations += places.len();
        }
        if places.len() <= AT_A_TIME || self.stand_in.is_some() {
            return self.compare_side_by_side(by, places);
        }
        // Each thread with a simulator of its own.
        let chunks = places.par_chunks(AT_A_TIME);
        let compared =
            chunks.map_init(|| self.clone(), |own, few| own.compare_side_by_side(by, few));
        compared.flatten().collect()
    }

    fn compare_side_by_side(&mut self, by: By, places: &[Vec<f64>]) -> Vec<Option<Vec<f64>>> {
        let ny = self.weights.sigma.len();
        let mut y = vec![vec![0.0; self.longest * ny]; places.len()];
        let mut all = vec![Some(vec![0.0; self.layout.residuals()]); places.len()];
        for s in 0..self.layout.segments.len() {
            let is_finite = |i: &usize| all[*i].is_some();
            let left: Vec<usize> = (0..places.len()).filter(is_finite).collect();
            let now: Vec<&[f64]> = left.iter().map(|&i| places[i].as_slice()).collect();
            let complete = self.simulate(by, s, &now, &mut y[..left.len()]);
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

    /// Residuals at several places, beside one where they are known (`z`, `r`): where runs are dear, as far as
    /// they change on the stand-in. `None` where they are not finite.
    pub(crate) fn residuals_beside(
        &mut self,
        [z, r]: [&[f64]; 2],
        places: &[Vec<f64>],
    ) -> Vec<Option<Vec<f64>>> {
        if self.stand_in.is_none() {
            return self.compare(By::Simulator, places);
        }
        let mut found = self.compare(By::StandIn, &[&[z.to_vec()], places].concat()).into_iter();
        let Some(Some(here)) = found.next() else { return vec![None; places.len()] };
        let change = |there: Vec<f64>| -> Vec<f64> {
            there.iter().zip(&here).zip(r).map(|((there, here), r)| r + there - here).collect()
        };
        found.map(|there| there.map(change)).collect()
    }

    /// A change of white residuals in units of another noise as a change of the residuals of this problem.
    pub(crate) fn reweighed(&self, change: &[f32], sigma: &[f64]) -> Vec<f64> {
        let mut residuals = vec![0.0; change.len()];
        for (segment, rows) in self.plan.segments.iter().zip(&self.layout.segments) {
            let (log, length) = (&self.plan.logs[segment.log], segment.to - segment.from);
            for (c, colour) in self.weights.colour.iter().enumerate() {
                let rows = rows.start + c * length..rows.start + (c + 1) * length;
                let unit = sigma[c] / self.weights.sigma[c];
                let measured = log.y[segment.from * log.ny..].iter().skip(c).step_by(log.ny);
                let values = change[rows.clone()].iter().zip(measured).map(|(change, y)| {
                    if y.is_finite() { unit * f64::from(*change) } else { f64::NAN }
                });
                colour.whiten(&values.collect::<Vec<f64>>(), &mut residuals[rows]);
            }
        }
        residuals
    }

    /// Whether runs are so dear that a stand-in gives the slopes.
    pub(crate) fn is_dear(&self) -> bool {
        self.stand_in.is_some() && !self.is_stood_in
    }

    /// Whether fits begin on the stand-in: not where the simulator has noise in itself, and one run shows little.
    pub(crate) fn begins_on_stand_in(&self) -> bool {
        self.is_dear() && self.simulator.repeats()
    }

    /// How to look for its minimum.
    pub(crate) fn search(&self) -> Search {
        let plain = Search::default();
        if self.is_dear() { plain.of_dear_runs() } else { plain }
    }

    /// The same problem, simulated by the stand-in alone where there is one: for questions about models, not
    /// about the log.
    #[must_use]
    pub(crate) fn on_stand_in(mut self) -> Self {
        self.is_stood_in = self.stand_in.is_some();
        self
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

    /// Covariance of the uncertain parameters of the nominal model with everything else unknown as well, in units of what
    /// was known before, when noise is `scale` times as large as the weights say.
    #[must_use]
    pub fn covariance(&self, at: &Minimum, scale: f64) -> Option<faer::Mat<f64>> {
        let factor = self.told(at, scale).0.factor()?;
        let (n, all) = (self.plan.shared.len(), self.layout.unknowns());
        let column = |i: usize| {
            let mut unit = vec![0.0; all];
            unit[i] = 1.0;
            factor.solve(&mut unit);
            unit
        };
        let columns: Vec<Vec<f64>> = (0..n).map(column).collect();
        Some(faer::Mat::from_fn(n, n, |i, j| columns[j][i]))
    }

    /// Standard deviation of each parameter of the effect, in its unit, when noise is `scale` times as large as the weights
    /// say; of a shape that no residual depends on, that of any value in its box.
    #[must_use]
    pub fn standard_errors(&self, at: &Minimum, scale: f64) -> Option<Vec<f64>> {
        let (equations, idle) = self.told(at, scale);
        let (factor, first) = (equations.factor()?, self.plan.shared.len());
        let deviation = |(i, v): (usize, &Variable)| {
            let [low, high] = self.bounds[first + i];
            let any = (high - low) / 12.0_f64.sqrt();
            v.scale * if idle[first + i] { any } else { factor.variance(first + i).sqrt() }
        };
        Some(self.effects.iter().enumerate().map(deviation).collect())
    }

    /// Normal equations with noise so many times as large as the weights say, without unknowns that no residual depends on,
    /// as the shape of a law without strength, which would make them singular; and which these are.
    fn told(&self, at: &Minimum, scale: f64) -> (Arrow, Vec<bool>) {
        let mut equations = at.equations(self, 1.0 / scale);
        let idle = equations.fix_idle();
        (equations, idle)
    }
}
