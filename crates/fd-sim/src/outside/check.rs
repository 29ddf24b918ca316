//! Whether a simulator keeps what the contract of a simulator promises.

mod repeat;

use std::time::Instant;

use super::{drive::Drive, spread::Spread};
use crate::simulate::{Run, Simulator, Tape};

/// Relative change of a parameter between two runs that must differ smoothly.
const NUDGE: f64 = 1e-7;
/// Relative size of differences of the second order below which outputs are as precise as they need be.
const FINE: f64 = 1e-12;
/// Relative difference up to which a whole run and its steps are the same but for rounding.
const ROUNDING: f64 = 1e-9;
/// Change of what says nothing of its size.
const TRIAL: f64 = 1e-3;

/// How bad a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Grade {
    /// As it should be.
    Fine,
    /// A diagnosis will run, but its user should know.
    Doubt,
    /// A diagnosis would go wrong.
    Broken,
}

/// One finding.
#[derive(Clone, Debug, PartialEq)]
pub struct Checked {
    /// What was looked at.
    pub what: &'static str,
    /// How bad it is.
    pub grade: Grade,
    /// What was found.
    pub text: String,
}

/// What was found out about a simulator.
#[derive(Clone, Debug, PartialEq)]
pub struct Conformance {
    /// Findings in the order in which they were made.
    pub findings: Vec<Checked>,
    /// Samples of a run.
    pub samples: usize,
    /// Time of a whole run in one call, in seconds.
    pub run: f64,
    /// Time of a run step by step, with a look at the outputs before each step, in seconds; NaN where the simulator
    /// does not step.
    pub steps: f64,
    /// Relative differences of the second order between runs 1e-7 apart: the precision of its outputs.
    pub precision: f64,
    /// By how much equal runs differ, where they do.
    pub spread: Option<Spread>,
}

impl Conformance {
    /// The worst of all findings.
    #[must_use]
    pub fn worst(&self) -> Grade {
        self.findings.iter().map(|finding| finding.grade).max().unwrap_or(Grade::Fine)
    }

    /// Seconds that so many runs take with one worker: half of them in one call, half step by step, as a
    /// diagnosis asks for them of a simulator that steps.
    #[must_use]
    pub fn cost(&self, runs: u64) -> f64 {
        let steps = if self.steps.is_nan() { self.run } else { self.steps };
        0.5 * runs as f64 * (self.run + steps)
    }
}

/// Runs through the same inputs, and what they are compared with.
struct Bench<'a> {
    simulator: &'a mut dyn Simulator,
    samples: usize,
    sizes: Vec<f64>,
    theta: Vec<f64>,
    x0: Vec<f64>,
    u: Vec<f64>,
    f: Vec<f64>,
    findings: Vec<Checked>,
    /// By how much equal runs differ.
    spread: Option<Spread>,
}

/// Checks a simulator with inputs within plus and minus `amplitude`. A simulator with a memory must have been told
/// to ask anew ([`OutsideSimulator::without_memory`](super::OutsideSimulator::without_memory)).
///
/// ```
/// use fd_sim::{model::Model, outside::{Grade, check}, simulate::EquationSimulator};
///
/// let model: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "lag"
/// sample_time = 0.1
/// parameters = { T = { unit = "s", value = 2.0 }, idle = { unit = "1", value = 1.0 } }
/// inputs = { u = { unit = "1" } }
/// states = { x = { unit = "1", initial = 0.0, derivative = "(u - x)/T" } }
/// outputs = { y = { unit = "1", value = "x" } }
/// "#.parse()?;
/// let found = check(&mut EquationSimulator::new(&model)?, 200, 1.0);
/// assert_eq!(found.worst(), Grade::Broken);
/// let broken: Vec<_> = found.findings.iter().filter(|f| f.grade == Grade::Broken).collect();
/// assert!(broken.len() == 1 && broken[0].text.contains("`idle`"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn check(simulator: &mut dyn Simulator, samples: usize, amplitude: f64) -> Conformance {
    let drive = Drive::random(samples.max(2), simulator.inputs().len(), amplitude);
    check_driven(simulator, drive)
}

/// Checks a simulator with inputs of one's own, such as those of a log.
pub fn check_driven(simulator: &mut dyn Simulator, drive: Drive) -> Conformance {
    let Drive { samples, u, sizes, by_steps } = drive;
    let nf = simulator.ports().len();
    let mut bench = Bench {
        theta: simulator.parameters().iter().map(|p| p.value).collect(),
        x0: simulator.initial().iter().map(|state| state.value).collect(),
        u,
        sizes,
        f: vec![0.0; samples * nf],
        findings: Vec::new(),
        spread: None,
        simulator,
        samples,
    };
    let mut found = Conformance {
        findings: Vec::new(),
        samples,
        run: f64::NAN,
        steps: f64::NAN,
        precision: f64::NAN,
        spread: None,
    };
    let (theta, x0) = (bench.theta.clone(), bench.x0.clone());
    // The first run starts what has to be started.
    let base = bench.run(&theta, &x0);
    if bench.goes_through(&base) {
        let begun = Instant::now();
        let again = bench.run(&theta, &x0);
        found.run = begun.elapsed().as_secs_f64();
        bench.repeats(&base, &again);
        if by_steps {
            let begun = Instant::now();
            let stepped = bench.by_steps();
            found.steps = begun.elapsed().as_secs_f64();
            bench.is_the_same_by_steps(&base, &stepped);
        }
        found.precision = bench.precision(&base);
        bench.parameters(&base);
        bench.natives(&base);
        bench.the_rest(&base);
    }
    (found.findings, found.spread) = (bench.findings, bench.spread);
    found
}

/// Largest difference of two series in parts of the largest value.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    let size = a.iter().fold(0.0_f64, |size, a| size.max(a.abs()));
    let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    let apart = apart.fold(0.0_f64, |most, d| if d.is_nan() { f64::NAN } else { most.max(d) });
    if apart == 0.0 { 0.0 } else { apart / size.max(f64::MIN_POSITIVE) }
}

impl Bench<'_> {
    fn say(&mut self, what: &'static str, grade: Grade, text: String) {
        self.findings.push(Checked { what, grade, text });
    }

    fn run(&mut self, theta: &[f64], x0: &[f64]) -> Vec<f64> {
        let mut y = vec![f64::NAN; self.samples * self.simulator.outputs().len()];
        let mut runs = [Run::new(theta, x0, &mut y)];
        self.simulator.simulate_many(0, &self.u, &mut runs);
        y
    }

    fn by_steps(&mut self) -> Vec<f64> {
        let (nu, ny) = (self.simulator.inputs().len(), self.simulator.outputs().len());
        let mut y = vec![f64::NAN; self.samples * ny];
        let mut seen = vec![f64::NAN; ny];
        self.simulator.start(&self.theta, &self.x0, 0);
        for (k, row) in y.chunks_exact_mut(ny).enumerate() {
            let u = &self.u[k * nu..(k + 1) * nu];
            let can_measure = self.simulator.measure(u, &mut seen);
            self.simulator.step(u, u, &[], row);
            if can_measure && self.spread.is_none() && apart(row, &seen) > ROUNDING {
                row.fill(f64::NAN);
            }
        }
        self.simulator.rest();
        y
    }

    fn goes_through(&mut self, y: &[f64]) -> bool {
        let ny = self.simulator.outputs().len();
        let Some(place) = y.iter().position(|value| !value.is_finite()) else {
            let text = format!("{} samples at the nominal parameters, all finite", self.samples);
            self.say("a run", Grade::Fine, text);
            return true;
        };
        let (sample, output) = (place / ny, &self.simulator.outputs()[place % ny].name);
        let text = format!("`{output}` is not finite at sample {sample} of the nominal run");
        self.say("a run", Grade::Broken, text);
        false
    }

    /// Differences of the second order of runs that are 1e-7 apart: rounding, and a curvature of 1e-14.
    fn precision(&mut self, base: &[f64]) -> f64 {
        let x0 = self.x0.clone();
        let mut worst = 0.0_f64;
        for i in 0..self.lent() {
            let [once, twice] = [1.0, 2.0].map(|n| {
                let mut theta = self.theta.clone();
                theta[i] += n * NUDGE * if theta[i] == 0.0 { 1.0 } else { theta[i] };
                self.run(&theta, &x0)
            });
            let straight: Vec<f64> = base.iter().zip(&twice).map(|(a, b)| 0.5 * (a + b)).collect();
            worst = worst.max(apart(&straight, &once));
        }
        if self.lent() == 0 {
            return f64::EPSILON;
        }
        let (grade, text) = if worst <= FINE {
            (Grade::Fine, format!("outputs are smooth to {worst:.1e}: double precision"))
        } else {
            let step = worst.sqrt();
            let text = format!(
                "outputs are smooth to {worst:.1e} only (single precision, a loose solver?): slopes \
                 need steps of about {step:.0e}, and a diagnosis may need twice the runs"
            );
            (if worst < TRIAL { Grade::Doubt } else { Grade::Broken }, text)
        };
        self.say("precision", grade, text);
        worst
    }

    /// Each parameter must move some output.
    fn parameters(&mut self, base: &[f64]) {
        let (x0, mut all) = (self.x0.clone(), self.simulator.parameters().to_vec());
        all.truncate(self.lent());
        let mut dead = Vec::new();
        let mut lost = Vec::new();
        for (i, parameter) in all.iter().enumerate() {
            let mut theta = self.theta.clone();
            let share = if parameter.tolerance > 0.0 { parameter.tolerance } else { TRIAL };
            theta[i] += share * if theta[i] == 0.0 { 1.0 } else { theta[i] };
            let y = self.run(&theta, &x0);
            match apart(base, &y) {
                d if d.is_nan() => lost.push(parameter.name.as_str()),
                _ if self.is_still(base, &y) => dead.push(parameter.name.as_str()),
                _ => {}
            }
        }
        if !dead.is_empty() {
            let text =
                format!("no output moves with {}{}: is it applied?", quoted(&dead), self.beyond());
            self.say("parameters", self.of_still(), text);
        }
        if !lost.is_empty() {
            let text = format!("runs diverge within the tolerance of {}", quoted(&lost));
            self.say("parameters", Grade::Doubt, text);
        }
        if dead.is_empty() && lost.is_empty() {
            self.say("parameters", Grade::Fine, format!("each of {} moves an output", all.len()));
        }
    }

    /// Parameters without those of native effects.
    fn lent(&self) -> usize {
        self.theta.len().saturating_sub(self.simulator.natives().len())
    }

    /// Native effects: one that moves nothing cannot be found with such a run, which need not be wrong.
    fn natives(&mut self, base: &[f64]) {
        let (x0, lent) = (self.x0.clone(), self.lent());
        let natives = self.simulator.natives().to_vec();
        let mut dead = Vec::new();
        for (i, native) in natives.iter().enumerate() {
            let mut theta = self.theta.clone();
            let high = native.parameter.bounds.map_or(f64::INFINITY, |[_, high]| high);
            let is_inside = theta[lent + i] + native.size <= high;
            theta[lent + i] += if is_inside { native.size } else { -native.size };
            let y = self.run(&theta, &x0);
            if self.is_still(base, &y) {
                dead.push(native.parameter.name.as_str());
            }
        }
        if !dead.is_empty() {
            let text = format!("no output moves with {} in this run", quoted(&dead));
            self.say("native effects", Grade::Doubt, text);
        } else if !natives.is_empty() {
            let text = format!("each of {} moves an output", natives.len());
            self.say("native effects", Grade::Fine, text);
        }
    }

    /// Initial states, inputs and ports.
    fn the_rest(&mut self, base: &[f64]) {
        let (theta, u) = (self.theta.clone(), self.u.clone());
        let force = TRIAL * self.sizes.iter().fold(0.0_f64, |most, size| most.max(*size));
        let force = if force == 0.0 { TRIAL } else { force };
        let mut dead = [Vec::new(), Vec::new(), Vec::new()];
        for i in 0..self.x0.len() {
            let mut x0 = self.x0.clone();
            let tolerance = self.simulator.initial()[i].tolerance;
            x0[i] += tolerance.unwrap_or(TRIAL * x0[i].abs().max(1.0));
            let y = self.run(&theta, &x0);
            if self.is_still(base, &y) {
                dead[0].push(self.simulator.initial()[i].channel.name.clone());
            }
        }
        let nu = self.simulator.inputs().len();
        for i in 0..nu {
            // A valve that is shut, or a switch: what a small change does not move, a large one may.
            let changes = [TRIAL, 1.0, -1.0, 100.0].map(|share| share * self.sizes[i].max(TRIAL));
            let is_dead = changes.iter().all(|change| {
                self.u.iter_mut().skip(i).step_by(nu).for_each(|u| *u += change);
                let x0 = self.x0.clone();
                let y = self.run(&theta, &x0);
                self.u.clone_from(&u);
                self.is_still(base, &y)
            });
            if is_dead {
                dead[1].push(self.simulator.inputs()[i].name.clone());
            }
        }
        let nf = self.simulator.ports().len();
        for i in 0..nf {
            let mut f = self.f.clone();
            f.iter_mut().skip(i).step_by(nf).for_each(|f| *f = force);
            let mut y = vec![f64::NAN; base.len()];
            let run = Run::new(&theta, &self.x0, &mut y);
            self.simulator.replay(0, &mut [Tape { run, u: &self.u, f: &f }]);
            if self.is_still(base, &y) {
                dead[2].push(self.simulator.ports()[i].channel.name.clone());
            }
        }
        let what = ["initial states", "inputs", "ports"];
        let counts = [self.x0.len(), nu, nf];
        for ((what, dead), count) in what.into_iter().zip(dead).zip(counts) {
            if !dead.is_empty() {
                let names: Vec<&str> = dead.iter().map(String::as_str).collect();
                let text = format!("no output moves with {}{}", quoted(&names), self.beyond());
                // Other values of an input, or another state of the plant, may be needed.
                let is_input = what == "inputs";
                let text = if is_input { text + " at the values that were tried" } else { text };
                self.say(what, if is_input { Grade::Doubt } else { self.of_still() }, text);
            } else if 0 < count {
                self.say(what, Grade::Fine, format!("each of {count} moves an output"));
            }
        }
    }
}

fn quoted(names: &[&str]) -> String {
    format!("`{}`", names.join("`, `"))
}
