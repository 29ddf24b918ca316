//! The data on which causes are told apart: the present logs and a new one, as the leading cause predicts them.

use std::sync::Arc;

use fd_model::{Channel, SampleTime};
use fd_sim::{
    equation::Expr,
    model::{Hold, Model, Output},
    simulate::{Outcome, Simulator, walk},
};

use super::{result::Sensor, rival::Contender};
use crate::{
    diagnose::Case,
    evidence::SEPARATED,
    fit::{
        FitError, Horizon, LeastSquares, Log, Plan, Problem, Search, Variable, Weights, minimise,
    },
    locate::bench::{Bench, settled},
};

/// Samples of the present logs that are simulated again.
const PRESENT_SAMPLES: usize = 600;
/// Iterations of a refit.
const ITERATIONS: usize = 12;
/// Growth of a tiny difference from the first to the last tenth of a run from which an input is
/// taken for chaotic or unstable.
const CHAOTIC: f64 = 1e3;
/// Relative size of the tiny difference.
const TINY: f64 = 1e-7;

/// The models of a comparison, with the sensor and the sampling of an experiment.
#[derive(Debug)]
pub(super) struct Arena<'a> {
    case: &'a Case<'a>,
    ts: SampleTime,
    faster: usize,
    sensor: Option<Sensor>,
    nominal: Box<dyn Simulator>,
    leader: Box<dyn Simulator>,
    leader_model: &'a Model,
    sigma: Vec<f64>,
    window: Option<usize>,
    present: Vec<Predicted>,
}

/// A log as the leader predicts it, with its states.
#[derive(Clone, Debug)]
struct Predicted {
    log: Log,
    states: Vec<f64>,
}

impl<'a> Arena<'a> {
    /// `None` when the models cannot be simulated with that sensor and sampling.
    pub(super) fn new(
        case: &'a Case<'a>,
        bench: &Bench,
        leader: &'a Model,
        starts: Option<&[crate::diagnose::Start]>,
        sensor: Option<Sensor>,
        faster: u32,
    ) -> Option<Self> {
        let seconds = bench.ts() / f64::from(faster);
        let ts = if faster == 1 { bench.simulator.ts() } else { SampleTime::new(seconds).ok()? };
        let with_sensor = |model: &Model| measured(model, sensor.as_ref());
        let nominal = case.nominal.patched(&with_sensor(case.nominal.model())?, ts).ok()?;
        let leader_simulator = case.nominal.patched(&with_sensor(leader)?, ts).ok()?;
        let mut sigma = bench.sigma.clone();
        sigma.extend(sensor.as_ref().map(|sensor| sensor.noise));
        let faster = faster as usize;
        let first = |s: &crate::fit::Segment| s.from == 0;
        let window = bench.segments.iter().find(|s| first(s) && bench.is_cut()).map(|s| s.to);
        let mut arena = Self {
            case,
            ts,
            faster,
            sensor,
            nominal,
            leader: leader_simulator,
            leader_model: leader,
            sigma,
            window: window.map(|samples| samples * faster),
            present: Vec::new(),
        };
        for (l, log) in bench.logs.iter().enumerate() {
            let log = log.prefix(PRESENT_SAMPLES.div_ceil(bench.logs.len()).max(50));
            let start = starts.and_then(|s| s.iter().find(|s| s.log == l && s.from == 0));
            let x0 = start.map(|start| start.state.clone());
            let mut predicted = arena.predict(&log.u, log.nu, x0.as_deref())?;
            // What was not measured, was not.
            for (k, row) in predicted.log.y.chunks_exact_mut(arena.sigma.len()).enumerate() {
                for (c, value) in row.iter_mut().enumerate() {
                    let is_sampled = k % faster == 0 && c < log.ny;
                    if !is_sampled || !log.y[k / faster * log.ny + c].is_finite() {
                        *value = f64::NAN;
                    }
                }
            }
            arena.present.push(predicted);
        }
        Some(arena)
    }

    /// What the leader makes of inputs on the time base of the logs.
    fn predict(&mut self, u: &[f64], nu: usize, x0: Option<&[f64]>) -> Option<Predicted> {
        let hold = self.leader_model.hold;
        let u = spread(u, nu, self.faster, hold);
        let ny = self.sigma.len();
        let samples = u.len() / nu.max(1);
        let initial: Vec<f64> = self.leader.initial().iter().map(|state| state.value).collect();
        let x0 = x0.filter(|x0| x0.len() == initial.len()).unwrap_or(&initial);
        let theta = settled(&*self.leader);
        let mut log = Log {
            u,
            y: vec![0.0; samples * ny],
            nu,
            ny,
            samples,
            first: 0,
            goes_on: false,
            is_in_motion: false,
            row: None,
            holes: Vec::new(),
            restarts: Vec::new(),
            lead: 0,
            circles: self.leader.outputs().iter().map(Channel::circle).collect(),
        };
        let mut states = Vec::with_capacity(samples * x0.len());
        let note = |_, now: &[f64]| states.extend_from_slice(now);
        let outcome = walk(&mut *self.leader, &theta, x0, 0, &log.u, &mut log.y, note);
        if outcome != Outcome::Complete {
            return None;
        }
        Some(Predicted { log, states })
    }

    /// Whether a tiny difference at the start grows beyond all bounds.
    fn is_chaotic(&mut self, u: &[f64], nu: usize, plain: &Predicted) -> bool {
        let nx = self.leader.initial().len();
        if plain.states.is_empty() {
            // A simulator that does not show its states cannot be moved a little.
            return false;
        }
        let mut x0: Vec<f64> = plain.states.iter().take(nx).copied().collect();
        for (i, x) in x0.iter_mut().enumerate() {
            let values = plain.states.iter().skip(i).step_by(nx);
            *x += TINY * values.fold(0.0_f64, |largest, v| largest.max(v.abs()));
        }
        let Some(moved) = self.predict(u, nu, Some(&x0)) else { return true };
        let differences: Vec<f64> =
            (moved.states.iter().zip(&plain.states)).map(|(a, b)| (a - b).abs()).collect();
        let tenth = differences.len().div_ceil(10).max(1);
        let top = |part: &[f64]| part.iter().copied().fold(0.0, f64::max);
        let (first, last) = (&differences[..tenth], &differences[differences.len() - tenth..]);
        CHAOTIC * top(first) < top(last)
    }

    /// For each rival, squares of the noise that remain when it is refitted to what the leader
    /// predicts of the present logs and, if any, of one with these inputs. `None` when the leader
    /// cannot be followed through them.
    pub(super) fn distances(
        &mut self,
        rivals: &[Contender<'_>],
        u: Option<&[f64]>,
    ) -> Option<Vec<f64>> {
        let mut all = self.present.clone();
        if let Some(u) = u {
            let nu = self.nominal.inputs().len();
            let predicted = self.predict(u, nu, None)?;
            if self.is_chaotic(u, nu, &predicted) {
                return None;
            }
            all.push(predicted);
        }
        let plan = Arc::new(self.plan(&all).ok()?);
        rivals.iter().map(|rival| self.distance(rival, &plan)).collect()
    }

    /// Nuisances are free within their boxes around those of the leader.
    fn plan(&self, all: &[Predicted]) -> Result<Plan, FitError> {
        let logs: Vec<Log> = all.iter().map(|predicted| predicted.log.clone()).collect();
        let horizon = self.window.map_or(Horizon::FreeRun, |samples| Horizon::Windows { samples });
        let plan = Plan::of_logs(&*self.nominal, logs.clone(), horizon)?;
        let value = |name: &str, otherwise: f64| {
            let known = self.leader_model.parameter(name);
            known.map_or(otherwise, |parameter| parameter.value)
        };
        let mut centre: Vec<f64> =
            plan.nuisances().iter().map(|v| value(&v.name, v.start)).collect();
        let states = self.leader.initial();
        for (segment, own) in plan.segments().iter().zip(&plan.own) {
            for variable in own {
                let place = states.iter().position(|s| s.channel.name == variable.name);
                let predicted = &all[segment.log].states;
                let value = place.map(|i| predicted[segment.from * states.len() + i]);
                centre.push(value.unwrap_or(variable.start));
            }
        }
        Ok(plan.moved(logs, &centre))
    }

    fn distance(&self, rival: &Contender<'_>, plan: &Arc<Plan>) -> Option<f64> {
        let model = measured(&rival.model, self.sensor.as_ref())?;
        let simulator = self.case.nominal.patched(&model, self.ts).ok()?;
        let weights = Weights::white(self.sigma.clone());
        let mut problem =
            Problem::new(Arc::clone(plan), simulator, rival.effects.clone(), weights).ok()?;
        let known = |variable: &Variable| {
            rival.fitted.parameter(&variable.name).map_or(0.0, |p| variable.scaled(p.value))
        };
        let own = problem.layout().own * problem.layout().segments.len();
        let moved: Vec<f64> =
            plan.nuisances().iter().map(known).chain(std::iter::repeat_n(0.0, own)).collect();
        let origin = vec![0.0; moved.len()];
        let search = Search { iterations: ITERATIONS, ..Search::default() };
        let mut least = f64::INFINITY;
        // From the rival's own fit, and from the leader's nuisances.
        for nuisances in [moved, origin] {
            let z = problem.place(&nuisances, &rival.values);
            if let Some(minimum) = minimise(&mut problem, &z, None, search) {
                least = least.min(minimum.cost);
            }
            if least < SEPARATED {
                break;
            }
        }
        Some(least)
    }
}

/// The model with a sensor of one of its states.
fn measured(model: &Model, sensor: Option<&Sensor>) -> Option<Model> {
    let Some(Sensor { state, noise }) = sensor else { return Some(model.clone()) };
    let unit = model.all_states().find(|known| known.name == *state)?.unit.clone();
    let mut draft = model.clone().into_draft();
    let name = draft.fresh_name(&format!("{state}_sensor"));
    let output = Output::new(name, unit, Expr::name(state));
    draft.outputs.push(Output { noise: Some(*noise), ..output });
    Model::try_from(draft).ok()
}

/// Inputs on a time base that is `faster` times as dense: what they are in between anyway.
fn spread(u: &[f64], nu: usize, faster: usize, hold: Hold) -> Vec<f64> {
    let samples = u.len() / nu.max(1);
    let mut dense = Vec::with_capacity(u.len() * faster);
    for k in 0..samples {
        let next = (k + 1).min(samples - 1);
        for part in 0..faster {
            let share = match hold {
                Hold::Zero => 0.0,
                Hold::Linear => part as f64 / faster as f64,
            };
            dense.extend((0..nu).map(|i| {
                let [now, next] = [u[k * nu + i], u[next * nu + i]];
                now + share * (next - now)
            }));
        }
    }
    dense
}
