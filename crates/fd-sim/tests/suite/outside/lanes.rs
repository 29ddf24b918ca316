//! Several runs in lock-step are what each is alone, with one call for all of them.

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
    },
    patch::Patch,
    simulate::{Initial, Nominal, Outcome, Port, Run, Shell, Simulator},
};

use super::{SAMPLES, inside, mass, open, process, push, ts};

/// Sliding masses, `v(k+1) = v(k) + (u + f)/m`, of which several are stepped in one call.
#[derive(Clone, Debug, Default)]
struct Masses {
    inertias: Vec<f64>,
    speeds: Vec<f64>,
    calls: Arc<AtomicUsize>,
    /// Calls of which the one of this number ends the simulator.
    fatal: Option<usize>,
}

/// Masses below this leave the region in which they can be simulated, as soon as they are fast.
const LIGHT: f64 = 0.1;

impl Masses {
    fn call(&self) -> Result<(), Lost> {
        let number = self.calls.fetch_add(1, Relaxed);
        if self.fatal == Some(number) {
            let simulator = "masses".to_owned();
            let (what, message) = ("a step".to_owned(), "it has ended".to_owned());
            let error = OutsideError::Raised { simulator, what, message };
            return Err(Lost::Gone(Box::new(error)));
        }
        Ok(())
    }
}

impl Instance for Masses {
    fn reset(&mut self, start: Start<'_>) -> Result<(), Lost> {
        self.reset_lanes(&[start])
    }

    fn measure(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Lost> {
        self.measure_lanes(1, u, y)
    }

    fn step(&mut self, row: &[f64], y: &mut [f64], x: &mut [f64]) -> Result<(), Lost> {
        self.step_lanes(1, row, y, x)
    }

    fn reset_lanes(&mut self, starts: &[Start<'_>]) -> Result<(), Lost> {
        self.call()?;
        self.inertias = starts.iter().map(|start| start.theta[0]).collect();
        self.speeds = starts.iter().map(|start| start.x0[0]).collect();
        Ok(())
    }

    fn measure_lanes(&mut self, lanes: usize, _: &[f64], y: &mut [f64]) -> Result<(), Lost> {
        assert_eq!(lanes, self.inertias.len());
        self.call()?;
        y.copy_from_slice(&self.speeds);
        Ok(())
    }

    fn step_lanes(
        &mut self,
        lanes: usize,
        rows: &[f64],
        y: &mut [f64],
        x: &mut [f64],
    ) -> Result<(), Lost> {
        assert_eq!(lanes, self.inertias.len());
        self.call()?;
        y.copy_from_slice(&self.speeds);
        let each = self.speeds.iter_mut().zip(&self.inertias).zip(rows.chunks_exact(2));
        for ((v, m), row) in each {
            *v += (row[0] + row[1]) / m;
            if *m < LIGHT && 20.0 < v.abs() {
                *v = f64::NAN;
            }
        }
        x.copy_from_slice(&self.speeds);
        Ok(())
    }
}

impl Source for Masses {
    fn open(&self) -> Result<Box<dyn Instance>, OutsideError> {
        Ok(Box::new(self.clone()))
    }
}

fn masses(lanes: usize, workers: usize, fatal: Option<usize>) -> (OutsideSimulator, Masses) {
    let source = Masses { fatal, ..Masses::default() };
    let contract = Contract {
        name: "masses".to_owned(),
        ts: SampleTime::new(1.0).unwrap(),
        inputs: vec![Channel::new("u", "N")],
        outputs: vec![Channel::new("speed", "m/s")],
        noise: vec![None],
        parameters: vec![Parameter::new("m", "kg", 2.0)],
        natives: Vec::new(),
        initial: vec![Initial { channel: Channel::new("v", "m/s"), value: 0.0, tolerance: None }],
        ports: vec![Port { channel: Channel::new("rail", "N") }],
        motion: vec![Motion { position: None, velocity: Some("speed".to_owned()) }],
        powers: Powers { measure: true, states: true, lanes, ..Powers::default() },
    };
    (OutsideSimulator::new(contract, source.clone(), workers).unwrap(), source)
}

/// A shell with friction in it, whose force depends on what the plant shows.
fn rubbed(shell: &Shell, velocity: &str, w: f64) -> Model {
    let mut patch = Patch::of(shell.model());
    patch.add_parameter(Parameter::new("w", "N", w));
    let friction = Expr::parse(&format!("-w*tanh({velocity}/0.3)")).unwrap();
    patch.add_force("rail", "friction", friction).unwrap();
    patch.finish().unwrap()
}

/// Outputs and ends of runs with these values of the first parameter.
fn runs(
    simulator: &mut dyn Simulator,
    values: &[f64],
    u: &[f64],
    ny: usize,
) -> Vec<(Vec<f64>, Outcome)> {
    let nominal: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
    let x0: Vec<f64> = simulator.initial().iter().map(|state| state.value).collect();
    let thetas: Vec<Vec<f64>> = values
        .iter()
        .map(|value| {
            let mut theta = nominal.clone();
            theta[0] = *value;
            theta
        })
        .collect();
    let mut y = vec![vec![0.0; u.len() * ny]; values.len()];
    let pairs = thetas.iter().zip(&mut y);
    let mut all: Vec<Run<'_>> = pairs.map(|(theta, y)| Run::new(theta, &x0, y)).collect();
    simulator.simulate_many(3, u, &mut all);
    let ends: Vec<Outcome> = all.iter().map(|run| run.outcome).collect();
    y.into_iter().zip(ends).collect()
}

fn bits(all: &[(Vec<f64>, Outcome)]) -> Vec<(Vec<u64>, Outcome)> {
    let bits = |y: &[f64]| y.iter().map(|y| y.to_bits()).collect();
    all.iter().map(|(y, end)| (bits(y), *end)).collect()
}

#[test]
fn one_call_per_step_gives_the_bits_of_each_lane_alone() {
    let u = push();
    // The light one diverges on its way: the others do not notice.
    let values = [2.0, 1.7, 0.01, 2.2, 3.1];
    let mut found = Vec::new();
    for (lanes, workers) in [(1, 1), (5, 1), (16, 1), (2, 1), (2, 3), (1, 3)] {
        let (simulator, source) = masses(lanes, workers, None);
        let shell = simulator.shell().unwrap();
        let model = rubbed(&shell, "speed_raw", 0.2);
        let mut patched = shell.patched(&model, simulator.ts()).unwrap();
        let before = source.calls.load(Relaxed);
        let seen = runs(&mut *patched, &values, &u, 1);
        let calls = source.calls.load(Relaxed) - before;
        println!("{lanes} lanes, {workers} workers: {calls} calls");
        if lanes >= values.len() && workers == 1 {
            // One reset; then what is there, and a step, for all lanes.
            assert_eq!(calls, 1 + 2 * SAMPLES);
        }
        assert_eq!(simulator.counts().made, values.len() as u64);
        found.push(bits(&seen));
    }
    assert!(found.iter().all(|seen| *seen == found[0]));
    let ends: Vec<bool> = found[0].iter().map(|(_, end)| *end == Outcome::Complete).collect();
    assert_eq!(ends, [true, true, false, true, true]);
}

#[test]
fn a_simulator_that_ends_in_the_middle_is_started_again_for_all_lanes() {
    let (u, values) = (push(), [2.0, 1.7, 3.1]);
    let seen = |fatal: Option<usize>| {
        let (simulator, _) = masses(4, 1, fatal);
        let shell = simulator.shell().unwrap();
        let model = rubbed(&shell, "speed_raw", 0.2);
        let mut patched = shell.patched(&model, simulator.ts()).unwrap();
        (bits(&runs(&mut *patched, &values, &u, 1)), simulator.counts())
    };
    let (whole, _) = seen(None);
    let (again, counts) = seen(Some(100));
    assert_eq!(whole, again);
    assert_eq!((counts.deaths, counts.started, counts.lost), (1, 2, 0));
}

#[test]
fn a_process_that_serves_lanes_gives_the_bits_of_the_plant() {
    let shell = |simulator: Box<dyn Simulator>| {
        let shell = Shell::new("mass", simulator).unwrap();
        shell.with_motion("rail", Some("place"), Some("speed")).unwrap()
    };
    let (u, plant) = (push(), shell(Box::new(inside())));
    let values: Vec<f64> =
        (0..11).map(|i| mass().nominal()[0] * (1.0 + 0.02 * f64::from(i))).collect();
    for manner in ["lanes", "lanes of runs"] {
        let process = open(process(&[manner]), 1).unwrap();
        let around = shell(process.boxed());
        for model in [rubbed(&plant, "speed_raw", 0.05), plant.model().clone()] {
            let mut pair = [&around, &plant].map(|shell| shell.patched(&model, ts()).unwrap());
            let [served, here] = pair.each_mut().map(|s| bits(&runs(&mut **s, &values, &u, 2)));
            // Where a process cannot measure, forces see the step before.
            if manner == "lanes" || model == *plant.model() {
                assert_eq!(served, here, "{manner}");
            }
        }
        assert_eq!(process.counts().made, 2 * values.len() as u64);
        assert_eq!(process.trouble(), None);
    }
}
