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

use fd_effect::{Candidate, Rounding, SiteRef};
use fd_sim::{
    equation::Expr,
    model::{Model, Output, Parameter},
    patch::Patch,
    simulate::{Nominal, Simulator},
};

use crate::fit::{NullFit, Segment};

/// Steps of finite differences, as fractions of the spread of a state or of the command.
const STEP: f64 = 1e-4;
/// Halves of a quantum per peak of the command: fewest and most that are tried.
const HALVES: [usize; 2] = [3, 1024];
/// Fewest and most quanta that are tried while the peak takes in one more. Eight will do where the
/// command takes many values, of which each has little weight …
const FINENESS: [usize; 2] = [8, 512];
/// … but few values jump to the next multiple with all their weight: this many, over the number of
/// values.
const FINER: usize = 8000;
/// Values of a command that differ by less than this part of its peak are one.
const SAME: f64 = 1e-9;
/// The best so many of each octave are worth a simulation.
const PER_OCTAVE: usize = 4;

/// A command with the slopes of the misfit.
#[derive(Clone, Debug)]
pub(in crate::diagnose) struct Command {
    levels: Vec<Level>,
}

/// A value that a command takes.
#[derive(Clone, Copy, Debug)]
struct Level {
    value: f64,
    /// Slope of half the sum of squares (in sigma) with respect to it.
    slope: f64,
    /// At how many samples it is taken.
    samples: f64,
}

/// The commands of inputs, by their names.
pub(in crate::diagnose) type Commands = HashMap<String, Command>;

impl Command {
    /// The commands that candidates round, in the run of a fit, of which `model` is the model.
    pub(in crate::diagnose) fn all(
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
    pub(in crate::diagnose) fn of_candidate<'a>(
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
        let mut samples: Vec<(f64, f64)> = Vec::new();
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
            samples.extend(run.command.into_iter().zip(slopes));
        }
        Some(Self { levels: levels(samples) })
    }

    /// Quanta that could explain most of the misfit: the best of each octave of those that are better
    /// than their neighbours. `peak` is the largest command.
    pub(in crate::diagnose) fn quanta(&self, rounding: Rounding, peak: f64) -> Vec<f64> {
        let [least, most] = FINENESS;
        let fineness = (FINER / self.levels.len().max(1)).clamp(least, most);
        let [first, last] = HALVES.map(|halves| halves * fineness / 2);
        let quantum = |i: usize| peak * fineness as f64 / i as f64;
        let merits: Vec<f64> = (first..=last).map(|i| self.merit(rounding, quantum(i))).collect();
        let merit = |i: usize| merits[i - first];
        let is_peak =
            |i: &usize| 0.0 < merit(*i) && merit(*i - 1) <= merit(*i) && merit(*i + 1) <= merit(*i);
        let mut found = Vec::new();
        let mut from = first + 1;
        while from < last {
            let to = (2 * from).min(last);
            let mut peaks: Vec<usize> = (from..to).filter(is_peak).collect();
            peaks.sort_by(|a, b| merit(*b).total_cmp(&merit(*a)));
            found.extend(peaks.into_iter().take(PER_OCTAVE).map(quantum));
            from = to;
        }
        found
    }

    /// How fast the misfit falls towards the command as rounded, per size of the change.
    fn merit(&self, rounding: Rounding, quantum: f64) -> f64 {
        let (mut along, mut squares) = (0.0, 0.0);
        for Level { value, slope, samples } in &self.levels {
            let change = rounding.apply(*value, quantum) - value;
            along += slope * change;
            squares += samples * change * change;
        }
        if 0.0 < squares { -along / squares.sqrt() } else { 0.0 }
    }
}

/// Samples of the same value as one.
fn levels(mut samples: Vec<(f64, f64)>) -> Vec<Level> {
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    let peak = samples.iter().fold(0.0_f64, |peak, (value, _)| peak.max(value.abs()));
    let mut levels: Vec<Level> = Vec::new();
    for (value, slope) in samples {
        match levels.last_mut() {
            Some(level) if value - level.value <= SAME * peak => {
                level.slope += slope;
                level.samples += 1.0;
            }
            _ => levels.push(Level { value, slope, samples: 1.0 }),
        }
    }
    levels
}

/// The model with something that can be added to an input, and the command as one more output;
/// with the name of what is added.
fn probe(model: &Model, input: &str) -> Option<(Model, String)> {
    let unit = model.inputs.iter().find(|known| known.name == input)?.unit.clone();
    let mut draft = model.clone().into_draft();
    let name = draft.fresh_name(&format!("{input}_command"));
    draft.outputs.push(Output::new(name, &unit, Expr::name(input)));
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use fd_model::{Channel, Record};
    use fd_sim::simulate::EquationSimulator;

    use super::*;
    use crate::fit::{Horizon, Log, Plan, Problem, Weights, null_fit};

    const MODEL: &str = r#"
        version = 1
        kind = "equations"
        name = "pendulum"
        sample_time = 0.02
        inputs = { u = { unit = "1/s^2" } }
        outputs = { y = { unit = "rad", value = "q", noise = 0.001 } }
        parameters = { g = { unit = "1/s^2", value = 20.0 } }
        [states]
        q = { unit = "rad", initial = 0.1, derivative = "w" }
        w = { unit = "rad/s", initial = 0.0, derivative = "u - 0.8*w - g*sin(q)" }
    "#;
    const SAMPLES: usize = 300;

    fn model() -> Model {
        MODEL.parse().unwrap()
    }

    fn command(k: usize) -> f64 {
        let t = 0.02 * k as f64;
        4.0 * (3.1 * t).sin() + 3.0 * (5.3 * t + 1.0).sin()
    }

    /// The fit to a plant with another command.
    fn fit(change: impl Fn(usize, f64) -> f64) -> NullFit {
        let model = model();
        let ts = model.sample_time().unwrap();
        let mut simulator = EquationSimulator::<f64>::at(&model, ts).unwrap();
        let run = |u: &[f64], simulator: &mut EquationSimulator<f64>| {
            let mut y = vec![0.0; SAMPLES];
            simulator.run(&model.nominal(), &model.initial(), u, &mut y);
            y
        };
        let u: Vec<f64> = (0..SAMPLES).map(command).collect();
        let real: Vec<f64> = u.iter().enumerate().map(|(k, u)| change(k, *u)).collect();
        let y = run(&real, &mut simulator);
        let (input, output) = ([Channel::new("u", "1/s^2")], [Channel::new("y", "rad")]);
        let record = Record::new(input.to_vec(), output.to_vec(), u, y, ts).unwrap();
        let plan = Plan::new(&simulator, &[record], Horizon::FreeRun).unwrap();
        null_fit(&Arc::new(plan), &simulator, &Weights::white(vec![0.001])).unwrap()
    }

    /// Slopes of the misfit are those of simulations with one sample of the command changed.
    #[test]
    fn slopes_are_those_of_the_misfit() {
        let model = model();
        let found = fit(|_, u| 1.1 * u);
        let command_found = Command::of(&model, &model, &found, "u").unwrap();
        let misfit = |k: usize, change: f64| {
            let mut plan = (**found.problem.plan()).clone();
            let Log { u, .. } = &mut plan.logs[0];
            u[k] += change;
            let simulator = found.problem.simulator().boxed();
            let weights = found.problem.weights().clone();
            let mut problem = Problem::new(Arc::new(plan), simulator, vec![], weights).unwrap();
            let errors = problem.errors(&found.minimum.z).unwrap();
            0.5 * errors[0][0].iter().map(|e| e * e).sum::<f64>()
        };
        for k in [0, 3, 50, 170, 290, SAMPLES - 1] {
            let step = 1e-3;
            let slope = (misfit(k, step) - misfit(k, -step)) / (2.0 * step);
            let nearest = command_found.levels.iter().min_by(|a, b| {
                (a.value - command(k)).abs().total_cmp(&(b.value - command(k)).abs())
            });
            let level = nearest.unwrap();
            assert!((level.value - command(k)).abs() < 1e-9);
            // Forward differences of 1e-4 of a range: as good as that, of the largest slope.
            let largest = command_found.levels.iter().fold(0.0_f64, |m, l| m.max(l.slope.abs()));
            assert!((level.slope - slope).abs() < 3e-3 * largest, "{k}: {} {slope}", level.slope);
        }
    }

    /// Of rounding to the nearest; truncation also makes the command smaller, which many quanta do.
    #[test]
    fn the_quantum_of_a_command_is_among_those_worth_a_simulation() {
        let (model, rounding) = (model(), Rounding::Nearest);
        for quantum in [1.3, 0.21] {
            let found = fit(|_, u| rounding.apply(u, quantum));
            let command = Command::of(&model, &model, &found, "u").unwrap();
            let peak = (0..SAMPLES).map(self::command).fold(0.0_f64, |m, u| m.max(u.abs()));
            let quanta = command.quanta(rounding, peak);
            // As near as the next one that was tried.
            let near = |other: &f64| (peak / other - peak / quantum).abs() <= 0.125;
            assert!(quanta.iter().any(near), "{quantum}: {quanta:?}");
            assert!(quanta.len() < 100);
        }
    }
}
