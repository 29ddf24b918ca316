//! A command as it reaches the plant, and how the misfit answers where it is off.
//!
//! What a coarse quantum does to a command is known to the last digit once the quantum is; only the
//! quantum is not, and outputs are nothing like smooth in it. Simulating every quantum that could be
//! is expensive. To first order the misfit `½ Σ e²` changes by `Σ gₖ (Q(uₖ) − uₖ)`, with `g` its
//! slopes with respect to the command of every sample, and thousands of quanta can be tried against
//! these. The slopes follow backwards in time from the model linearised around its run (the adjoint
//! of the discrete system; Bryson & Ho, *Applied Optimal Control*, 1975, section 2.2).
//!
//! *When not to use:* for quanta that move the plant far from its run. Coarse quanta are few, and
//! can be simulated.

use std::collections::HashMap;

use crate::{
    effect::{Candidate, Rounding, SiteRef},
    equation::Expr,
    fit::{NullFit, Segment},
    model::{Model, Output, Parameter},
    patch::Patch,
    simulate::{Nominal, Simulator},
};

/// Steps of finite differences, as fractions of the spread of a state or of the command.
const STEP: f64 = 1e-4;
/// Eighths of a quantum per peak of the command: the first and the last that are tried.
const EIGHTHS: [u32; 2] = [64, 4096];
/// The best so many of each octave are worth a simulation.
const PER_OCTAVE: usize = 8;

/// A command with the slopes of the misfit.
#[derive(Clone, Debug)]
pub(super) struct Command {
    /// What arrives at each sample, segment by segment.
    values: Vec<f64>,
    /// Slopes of half the sum of squares (in sigma) with respect to these.
    slopes: Vec<f64>,
}

/// The commands of inputs, by their names.
pub(super) type Commands = HashMap<String, Command>;

impl Command {
    /// The commands that candidates round, in the run of a fit, of which `model` is the model.
    pub(super) fn all(
        nominal: &dyn Nominal,
        model: &Model,
        fit: &NullFit,
        candidates: &[Candidate],
    ) -> Commands {
        let mut commands = Commands::new();
        for candidate in candidates.iter().filter(|candidate| candidate.rounding.is_some()) {
            if let SiteRef::Input(_, name) = &candidate.site
                && !commands.contains_key(name)
                && let Some(command) = Self::of(nominal, model, fit, name)
            {
                commands.insert(name.clone(), command);
            }
        }
        commands
    }

    /// The command that a candidate acts on.
    pub(super) fn of_candidate<'a>(
        commands: &'a Commands,
        candidate: &Candidate,
    ) -> Option<&'a Self> {
        commands.get(candidate.site.name()?)
    }

    /// The command of an input in the run of a fit, of which `model` is the model. `None` where the
    /// simulator does not let itself be put on another course, or has no such input.
    fn of(nominal: &dyn Nominal, model: &Model, fit: &NullFit, input: &str) -> Option<Self> {
        let (probe, nudge) = probe(model, input)?;
        let mut problem = fit.problem.clone();
        let z = &fit.minimum.z;
        let errors = problem.errors(z)?;
        let simulator = nominal.patched(&probe, problem.simulator().ts()).ok()?;
        let place = simulator.parameters().iter().position(|p| p.name == nudge)?;
        let mut theta = problem.parameters(z);
        theta.insert(place.min(theta.len()), 0.0);
        let mut command = Self { values: Vec::new(), slopes: Vec::new() };
        let plan = problem.plan();
        for (s, segment) in plan.segments().iter().enumerate() {
            let log = &plan.logs[segment.log];
            let u = |k: usize| [log.input(segment.from + k), log.input(segment.from + k + 1)];
            let course = Course {
                simulator: &*simulator,
                theta: &theta,
                nudge: place,
                x0: &problem.start_of(s, z),
                first: (log.first + segment.from) as u64,
                u: &u,
            };
            let Segment { from, to, .. } = *segment;
            let run = course.run(to - from)?;
            let sigma = &problem.weights().sigma;
            let pull = |k: usize| -> Vec<f64> {
                let of = |(e, sigma): (&Vec<Vec<f64>>, &f64)| {
                    if e[s][k].is_finite() { e[s][k] / sigma } else { 0.0 }
                };
                errors.iter().zip(sigma).map(of).collect()
            };
            let slopes = course.slopes(&run, pull)?;
            command.values.extend(&run.command);
            command.slopes.extend(slopes);
        }
        Some(command)
    }

    /// Quanta that could explain most of the misfit, of all that are between an eighth of `peak` and
    /// a few hundredths of a hundredth of it: the best of each octave that are better than their
    /// neighbours.
    pub(super) fn quanta(&self, rounding: Rounding, peak: f64) -> Vec<f64> {
        let [first, last] = EIGHTHS;
        let quantum = |eighths: u32| 8.0 * peak / f64::from(eighths);
        let merits: Vec<f64> =
            (first..=last).map(|eighths| self.merit(rounding, quantum(eighths))).collect();
        let mut found = Vec::new();
        let mut from = first;
        while from < last {
            let to = (2 * from).min(last);
            let merit = |eighths: u32| {
                let place = eighths.checked_sub(first)?;
                merits.get(place as usize).copied()
            };
            let is_peak = |eighths: &u32| {
                let here = merit(*eighths).unwrap_or(0.0);
                let is_less = |other: Option<f64>| other.is_none_or(|other| other <= here);
                0.0 < here && is_less(merit(eighths - 1)) && is_less(merit(eighths + 1))
            };
            let mut peaks: Vec<u32> = (from..to).filter(is_peak).collect();
            peaks.sort_by(|a, b| merit(*b).unwrap_or(0.0).total_cmp(&merit(*a).unwrap_or(0.0)));
            found.extend(peaks.into_iter().take(PER_OCTAVE).map(quantum));
            from = to;
        }
        found
    }

    /// How fast the misfit falls towards the command as rounded, per size of the change.
    fn merit(&self, rounding: Rounding, quantum: f64) -> f64 {
        let (mut along, mut squares) = (0.0, 0.0);
        for (u, slope) in self.values.iter().zip(&self.slopes) {
            let change = rounding.apply(*u, quantum) - u;
            along += slope * change;
            squares += change * change;
        }
        if 0.0 < squares { -along / squares.sqrt() } else { 0.0 }
    }
}

/// The model with something that can be added to an input, and the command as one more output;
/// with the name of what is added.
fn probe(model: &Model, input: &str) -> Option<(Model, String)> {
    let unit = model.inputs.iter().find(|known| known.name == input)?.unit.clone();
    let mut draft = model.clone().into_draft();
    let name = draft.fresh_name(&format!("{input}_command"));
    draft.outputs.push(Output { name, unit: unit.clone(), value: Expr::name(input), noise: None });
    let mut patch = Patch::of(&Model::try_from(draft).ok()?);
    let nudge = patch.fresh_name(&format!("{input}_nudge"));
    let nudged = patch.fresh_name(&format!("{input}_nudged"));
    patch.add_parameter(Parameter::new(nudge.clone(), unit, 0.0));
    let sum = Expr::parse(&format!("{input} + {nudge}")).ok()?;
    patch.wrap_input(input, &nudged, sum).ok()?;
    Some((patch.finish().ok()?, nudge))
}

/// A run that can be left at every sample.
struct Course<'a> {
    simulator: &'a dyn Simulator,
    theta: &'a [f64],
    /// Place of what is added to the input among the parameters.
    nudge: usize,
    x0: &'a [f64],
    first: u64,
    /// Inputs of a sample of the segment, and of the next one.
    u: &'a dyn Fn(usize) -> [&'a [f64]; 2],
}

/// States (one row more than samples), outputs and command of a run.
struct Run {
    states: Vec<f64>,
    outputs: Vec<f64>,
    command: Vec<f64>,
}

impl Course<'_> {
    fn run(&self, samples: usize) -> Option<Run> {
        let mut simulator = self.simulator.boxed();
        let mut y = vec![0.0; simulator.outputs().len()];
        let mut run = Run { states: Vec::new(), outputs: Vec::new(), command: Vec::new() };
        simulator.start(self.theta, self.x0, self.first);
        for k in 0..samples {
            run.states.extend(simulator.state());
            let [now, next] = (self.u)(k);
            simulator.step(now, next, &[], &mut y);
            run.outputs.extend(&y);
            run.command.extend(y.last());
        }
        run.states.extend(simulator.state());
        run.outputs.iter().all(|value| value.is_finite()).then_some(run)
    }

    /// Slopes of the misfit with respect to the command of each sample; `pull` has its slopes with
    /// respect to the outputs.
    fn slopes(&self, run: &Run, pull: impl Fn(usize) -> Vec<f64>) -> Option<Vec<f64>> {
        let (nx, ny) = (self.x0.len(), self.simulator.outputs().len());
        let samples = run.command.len();
        let spread = |values: &mut dyn Iterator<Item = f64>| {
            let range = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
                [low.min(v), high.max(v)]
            });
            (range[1] - range[0]).max(1e-3 * range[0].abs().max(range[1].abs())).max(1e-9)
        };
        let mut steps: Vec<f64> = (0..nx)
            .map(|i| STEP * spread(&mut run.states.iter().skip(i).step_by(nx).copied()))
            .collect();
        steps.push(STEP * spread(&mut run.command.iter().copied()));
        // One simulator per state, and one for the command: each takes every step from a place that
        // is a little off.
        let mut simulators: Vec<Box<dyn Simulator>> = Vec::with_capacity(nx + 1);
        for i in 0..=nx {
            let mut simulator = self.simulator.boxed();
            let mut theta = self.theta.to_vec();
            if i == nx {
                theta[self.nudge] += steps[nx];
            }
            simulator.start(&theta, self.x0, self.first);
            simulators.push(simulator);
        }
        // Per sample and direction: slopes of the next state and of the outputs.
        let mut slopes = Vec::with_capacity(samples * (nx + 1) * (nx + ny - 1));
        let (mut x, mut y) = (vec![0.0; nx], vec![0.0; ny]);
        for k in 0..samples {
            let [now, next] = (self.u)(k);
            for (i, simulator) in simulators.iter_mut().enumerate() {
                x.copy_from_slice(&run.states[k * nx..(k + 1) * nx]);
                if let Some(x) = x.get_mut(i) {
                    *x += steps[i];
                }
                if !simulator.go_on_from(&x) {
                    return None;
                }
                simulator.step(now, next, &[], &mut y);
                let moved = simulator.state().iter().zip(&run.states[(k + 1) * nx..]);
                slopes.extend(moved.map(|(there, here)| (there - here) / steps[i]));
                // The last output is the command.
                let changed = y[..ny - 1].iter().zip(&run.outputs[k * ny..]);
                slopes.extend(changed.map(|(there, here)| (there - here) / steps[i]));
            }
        }
        let width = nx + ny - 1;
        let mut costate = vec![0.0; nx];
        let mut found = vec![0.0; samples];
        for k in (0..samples).rev() {
            let pulls: Vec<f64> = costate.iter().copied().chain(pull(k)).collect();
            let rows = slopes[k * (nx + 1) * width..].chunks_exact(width).take(nx + 1);
            let sums = rows.map(|row| row.iter().zip(&pulls).map(|(a, b)| a * b).sum::<f64>());
            for (i, sum) in sums.enumerate() {
                match costate.get_mut(i) {
                    Some(costate) => *costate = sum,
                    None => found[k] = sum,
                }
            }
        }
        found.iter().all(|slope| slope.is_finite()).then_some(found)
    }
}
