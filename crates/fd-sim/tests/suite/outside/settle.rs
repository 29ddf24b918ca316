//! Runs of a simulator that makes whole runs only, with forces that depend on what it shows, are those of steps.

use std::sync::{
    Arc,
    atomic::{AtomicUsize, Ordering::Relaxed},
};

use fd_model::{Channel, SampleTime};
use fd_sim::{
    equation::Expr,
    model::{Model, Parameter},
    outside::{
        Contract, Instance, Lost, Motion, OutsideError, OutsideSimulator, Powers, Source, Start,
        by_steps,
    },
    patch::Patch,
    simulate::{EquationSimulator, Initial, Nominal, Outcome, Port, Shell, Simulator},
    stand_in::{Replay, StandIn},
};

const SAMPLES: usize = 400;
/// What rounded outputs are rounded beside: they have eight bits less than single precision.
const OFFSET: f64 = 100.0;
/// Runs are taken for lost beyond this angle.
const FAR: f64 = 50.0;

/// A pendulum that is pushed: linear with a small `g`, and swinging widely with a large one.
fn pendulum() -> Model {
    r#"
version = 1
kind = "equations"
name = "pendulum"
sample_time = 0.05
parameters = { g = { unit = "1/s^2", value = 6.0, tolerance = 0.05 } }
inputs = { u = { unit = "1/s^2" }, push = { unit = "1/s^2" } }
outputs = { angle = { unit = "rad", value = "q" }, speed = { unit = "rad/s", value = "w" } }
[states]
q = { unit = "rad", initial = 0.0, derivative = "w" }
w = { unit = "rad/s", initial = 0.0, derivative = "u + push - g*sin(q) - 0.3*w" }
"#
    .parse()
    .unwrap()
}

/// The pendulum, of which the second input is a force at a port. Whole runs are counted.
#[derive(Clone, Debug)]
struct Lent {
    plant: EquationSimulator,
    runs: Arc<AtomicUsize>,
    /// Whether outputs are rounded to single precision, about a large value.
    is_rounded: bool,
}

impl Instance for Lent {
    fn reset(&mut self, Start { theta, x0, first }: Start<'_>) -> Result<(), Lost> {
        self.plant.start(theta, x0, first);
        Ok(())
    }

    fn measure(&mut self, row: &[f64], y: &mut [f64]) -> Result<(), Lost> {
        let with_port = [row, &[0.0]].concat();
        if self.plant.measure(&with_port, y) { Ok(()) } else { Err(Lost::Refused) }
    }

    fn step(&mut self, row: &[f64], y: &mut [f64], _: &mut [f64]) -> Result<(), Lost> {
        self.plant.step(row, row, &[], y);
        if self.is_rounded {
            #[expect(clippy::cast_possible_truncation, reason = "that is the point")]
            for y in y.iter_mut() {
                *y = f64::from((*y + OFFSET) as f32) - OFFSET;
            }
        }
        if y[0].abs() < FAR { Ok(()) } else { Err(Lost::Refused) }
    }

    fn rollout(
        &mut self,
        start: Start<'_>,
        rows: &[f64],
        samples: usize,
        y: &mut [f64],
        x: &mut [f64],
    ) -> Result<(), Lost> {
        self.runs.fetch_add(1, Relaxed);
        by_steps(self, start, rows, samples, y, x)
    }
}

impl Source for Lent {
    fn open(&self) -> Result<Box<dyn Instance>, OutsideError> {
        Ok(Box::new(self.clone()))
    }
}

fn simulator(is_whole: bool, is_rounded: bool) -> (OutsideSimulator, Arc<AtomicUsize>) {
    let ts = SampleTime::new(0.05).unwrap();
    let runs = Arc::new(AtomicUsize::new(0));
    let plant = EquationSimulator::at(&pendulum(), ts).unwrap();
    let state =
        |name, unit| Initial { channel: Channel::new(name, unit), value: 0.0, tolerance: None };
    let contract = Contract {
        name: "pendulum".to_owned(),
        ts,
        inputs: vec![Channel::new("u", "1/s^2")],
        outputs: vec![Channel::new("angle", "rad"), Channel::new("speed", "rad/s")],
        noise: vec![None, None],
        parameters: vec![Parameter::new("g", "1/s^2", 6.0)],
        natives: Vec::new(),
        initial: vec![state("q", "rad"), state("w", "rad/s")],
        ports: vec![Port { channel: Channel::new("hinge", "1/s^2") }],
        motion: vec![Motion {
            position: Some("angle".to_owned()),
            velocity: Some("speed".to_owned()),
        }],
        powers: Powers {
            step: !is_whole,
            measure: !is_whole,
            rollout: is_whole,
            ..Powers::default()
        },
    };
    let lent = Lent { plant, runs: Arc::clone(&runs), is_rounded };
    (OutsideSimulator::new(contract, lent, 1).unwrap(), runs)
}

/// Levels of some height, each held for twenty samples.
fn levels(height: f64) -> Vec<f64> {
    (0..SAMPLES).map(|k| height * [1.0, -0.7, 0.2, 1.3, -1.1, 0.0][k / 20 % 6]).collect()
}

/// A shell with a force at the hinge.
fn forced(shell: &Shell, force: &str) -> Model {
    let mut patch = Patch::of(shell.model());
    patch.add_parameter(Parameter::new("c", "1/s^2", 0.4));
    patch.add_force("hinge", "missing", Expr::parse(force).unwrap()).unwrap();
    patch.finish().unwrap()
}

/// Outputs of a run with this force, its end, and how many whole runs it took; of which a linear model is known or not.
fn run(is_whole: bool, is_foretold: bool, force: &str, u: &[f64]) -> (Vec<f64>, Outcome, usize) {
    run_on(simulator(is_whole, false), is_foretold, force, u)
}

fn run_on(
    (simulator, runs): (OutsideSimulator, Arc<AtomicUsize>),
    is_foretold: bool,
    force: &str,
    u: &[f64],
) -> (Vec<f64>, Outcome, usize) {
    let shell = simulator.shell().unwrap();
    if is_foretold {
        let replay = Replay { u, samples: SAMPLES, first: 0, x0: None, driven: None };
        StandIn::of(&shell, simulator.ts(), &[replay], &[0.4], None).unwrap().unwrap();
    }
    let before = runs.load(Relaxed);
    let mut patched = shell.patched(&forced(&shell, force), simulator.ts()).unwrap();
    let mut y = vec![0.0; 2 * SAMPLES];
    let outcome = patched.simulate(&[6.0, 0.4], &[0.0, 0.0], u, &mut y);
    (y, outcome, runs.load(Relaxed) - before)
}

#[test]
fn a_few_whole_runs_are_what_steps_are() {
    // Small and wide swings, rubbed and pushed on; the last force is not even continuous.
    for (height, force, most) in [
        (0.1, "-c*speed_raw", 6),
        (0.1, "-c*tanh(speed_raw/0.01)", 8),
        (4.0, "-c*speed_raw", 14),
        (4.0, "-c*tanh(speed_raw/0.05)", 20),
        (4.0, "c*(if(angle_raw > 0.3, 1, 0))", 20),
    ] {
        let u = levels(height);
        let (steps, ..) = run(false, false, force, &u);
        let (found, outcome, runs) = run(true, true, force, &u);
        let range = steps.iter().fold(0.0_f64, |most, y| most.max(y.abs()));
        let off = steps.iter().zip(&found).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("{force}, inputs of {height}: {runs} runs, {:.1e} off", off / range);
        assert_eq!(outcome, Outcome::Complete);
        // The promise is 1e-6 of the range of each output, the smaller of which is a third of the larger.
        assert!(off < 3e-6 * range && runs <= most, "{off} of {range} after {runs} runs");
    }
}

/// What drove a run is where the next one begins, with other parameters or a little more friction.
#[test]
fn runs_that_are_like_others_take_fewer() {
    let (simulator, runs) = simulator(true, false);
    let (shell, u) = (simulator.shell().unwrap(), levels(0.1));
    let replay = Replay { u: &u, samples: SAMPLES, first: 0, x0: None, driven: None };
    StandIn::of(&shell, simulator.ts(), &[replay], &[0.4], None).unwrap().unwrap();
    let model = forced(&shell, "-c*tanh(speed_raw/0.01)");
    let (mut again, fresh) = (shell.patched(&model, simulator.ts()).unwrap(), simulator.ts());
    let mut counts = Vec::new();
    for c in [0.4, 0.401, 0.4012, 0.402] {
        let mut y = [vec![0.0; 2 * SAMPLES], vec![0.0; 2 * SAMPLES]];
        let before = runs.load(Relaxed);
        again.simulate(&[6.01, c], &[0.0, 0.0], &u, &mut y[0]);
        counts.push(runs.load(Relaxed) - before);
        let mut new = shell.patched(&model, fresh).unwrap();
        new.simulate(&[6.01, c], &[0.0, 0.0], &u, &mut y[1]);
        let range = y[1].iter().fold(0.0_f64, |most, y| most.max(y.abs()));
        let off = y[0].iter().zip(&y[1]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // Each is right to 1e-6 of the range of each output.
        assert!(off < 6e-6 * range, "{off} of {range}");
    }
    println!("{counts:?} runs");
    assert!(counts[1..].iter().all(|count| *count < counts[0]), "{counts:?}");
}

/// Rounded outputs never settle to the bit: what a pass changes then is rounding, and no reason for another one.
#[test]
fn rounded_outputs_settle_to_their_rounding() {
    let (u, force) = (levels(4.0), "-c*tanh(speed_raw/0.01)");
    let (steps, ..) = run(false, false, force, &u);
    let (found, outcome, runs) = run_on(simulator(true, true), true, force, &u);
    let off = steps.iter().zip(&found).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("{runs} runs, {off:.1e} off");
    assert_eq!(outcome, Outcome::Complete);
    // Rounded to 8e-6; each force that differs by that moves what comes after it.
    assert!(off < 1e-3 && runs < 30, "{off} after {runs} runs");
}

#[test]
fn a_run_that_is_lost_on_its_way_is_lost_at_the_same_sample() {
    // A force that drives it on and on.
    let (u, force) = (levels(4.0), "c*speed_raw*3");
    let (steps, lost, _) = run(false, false, force, &u);
    let Outcome::Diverged { sample } = lost else { panic!("it is meant to be lost") };
    let (found, outcome, runs) = run(true, true, force, &u);
    println!("lost at {sample} after {runs} runs");
    assert_eq!(outcome, lost);
    let range = steps[..2 * sample].iter().fold(0.0_f64, |most, y| most.max(y.abs()));
    let pairs = steps[..2 * sample].iter().zip(&found);
    assert!(pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-5 * range);
    assert!(found[2 * sample..].iter().all(|y| y.is_nan()));
}

#[test]
fn without_a_linear_model_each_sample_is_a_run() {
    let u = levels(0.1);
    let (steps, ..) = run(false, false, "-c*speed_raw", &u);
    let (found, _, runs) = run(true, false, "-c*speed_raw", &u);
    assert_eq!(found, steps);
    assert!(SAMPLES / 2 < runs, "{runs}");
}
