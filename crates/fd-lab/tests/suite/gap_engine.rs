//! The nonlinear engine with one withheld cause against the linear and the nominal simulator.
//! The full table is an example: `cargo run --release -p fd-lab --example gap_engine`.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests panic to fail")]

use fd_effect::{Effect, input::InputLag, sensor};
use fd_gap::diagnose::Diagnosis;
use fd_jetengine::engine17::{Engine17, Health, HealthParameter, Parameters};
use fd_lab::engine_gap::{
    Answer, EngineCause, diagnose_engine, diagnose_with_few_runs, engine_log,
};
use fd_log::{LogMap, read_log};
use fd_model::SampleTime;
use fd_sim::simulate::{EquationSimulator, Nominal, Outcome, Simulator};
use fdiag::engine_plant::{
    BLEED_LEAK, EngineKnowledge, EngineSimulator, HEAT_SOAK, MODULE_EFFICIENCY, engine_effects,
    linear_engine, simulator,
};

/// Samples every 40 ms, simulated in steps of 6.7 ms.
fn known() -> EngineKnowledge {
    EngineKnowledge {
        step: 0.04 / 6.0,
        ..EngineKnowledge::at(0.712, SampleTime::new(0.04).unwrap())
    }
}

/// A part of the library, small enough for the gate.
fn few() -> Vec<Box<dyn Effect>> {
    vec![
        Box::new(MODULE_EFFICIENCY),
        Box::new(BLEED_LEAK),
        Box::new(HEAT_SOAK),
        Box::new(InputLag),
        Box::new(sensor::SensorBias),
    ]
}

fn find(
    known: &EngineKnowledge,
    is_linear: bool,
    effects: Vec<Box<dyn Effect>>,
    cause: EngineCause,
    samples: usize,
    seed: u64,
) -> (Answer, Diagnosis) {
    let log = engine_log(known, cause, samples, seed).unwrap();
    let nominal = simulator(known, is_linear).unwrap();
    let diagnosis = diagnose_engine(&*nominal, effects, &log).unwrap();
    (Answer::of(&diagnosis, cause), diagnosis)
}

#[test]
fn the_simulator_is_the_engine() {
    let known = known();
    let engine = Engine17::new(&Parameters::default()).unwrap();
    let mut simulator = EngineSimulator::new(&known).unwrap();
    let nominal: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
    let fuel: Vec<f64> = vec![0.712; 50];
    let mut y = vec![0.0; 250];
    for parameter in HealthParameter::ALL {
        let mut theta = nominal.clone();
        let place = simulator.parameters().iter().position(|p| p.name == parameter.name()).unwrap();
        theta[place] += 0.01;
        // It settles where the engine in that health does, and stays there.
        let outcome = simulator.simulate(&theta, &[0.0; 19], &fuel, &mut y);
        assert_eq!(outcome, Outcome::Complete);
        let health = Health::default().shifted(parameter, 0.01);
        let settled = engine.clone().with_health(health).trim(0.712).unwrap().outputs();
        for row in y.chunks(5) {
            for (y, settled) in row.iter().zip(settled) {
                // Trims leave rates of 1e-9 per second.
                assert!((y / settled - 1.0).abs() < 1e-8, "{parameter:?}: {y} {settled}");
            }
        }
    }
    // Surge is a divergence, not a panic, and over when the simulator starts again.
    let slam = vec![2.5; 50];
    assert!(matches!(
        simulator.simulate(&nominal, &[0.0; 19], &slam, &mut y),
        Outcome::Diverged { .. }
    ));
    assert_eq!(simulator.simulate(&nominal, &[0.0; 19], &fuel, &mut y), Outcome::Complete);
}

/// The logs to try `fdiag gap` on are what they are said to be.
#[test]
fn the_logs_of_the_example_are_those_of_this_engine() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/gap/engine/");
    let known = EngineKnowledge::at(0.712, SampleTime::new(0.04).unwrap());
    let worn = EngineCause::Health(HealthParameter::HpcEfficiency, -0.015);
    for (file, cause, seed) in [("worn.csv", worn, 7), ("valve.csv", EngineCause::FuelLag(0.15), 8)]
    {
        let made = engine_log(&known, cause, 600, seed).unwrap();
        let map = LogMap::for_channels(made.inputs(), made.outputs());
        let log = read_log(format!("{folder}{file}"), &map).unwrap().record;
        assert_eq!(log.len(), made.len());
        let is_near = |(a, b): (&f64, &f64)| (a / b - 1.0).abs() < 1e-6;
        for ((u, y), (u_made, y_made)) in log.samples().zip(made.samples()) {
            // Seven digits.
            assert!(u.iter().zip(u_made).all(is_near) && y.iter().zip(y_made).all(is_near));
        }
    }
}

#[test]
fn the_linear_engine_settles_where_the_nonlinear_one_does() {
    let known = known();
    let linear = linear_engine(&known, &[]).unwrap();
    let engine = Engine17::new(&Parameters::default()).unwrap();
    let mut simulator = EquationSimulator::<f64>::new(&linear).unwrap();
    for parameter in HealthParameter::ALL {
        for shift in [-0.005, 0.015] {
            let mut theta = linear.nominal();
            let place = linear.parameters.iter().position(|p| p.name == parameter.name()).unwrap();
            theta[place] += shift;
            let mut y = vec![0.0; 5];
            let x0 = linear.initial();
            let _ = Simulator::simulate(&mut simulator, &theta, &x0, &[0.712], &mut y);
            let health = Health::default().shifted(parameter, shift);
            let settled = engine.clone().with_health(health).trim(0.712).unwrap().outputs();
            for (y, settled) in y.iter().zip(settled) {
                // A parabola through shifts of 1 % misses the third order, some (1.5 %)^3.
                assert!((y / settled - 1.0).abs() < 2e-5, "{parameter:?} {shift}: {y} {settled}");
            }
        }
    }
}

#[test]
fn the_linear_engine_follows_the_nonlinear_one() {
    let known = known();
    let (linear, nonlinear) = (simulator(&known, true).unwrap(), simulator(&known, false).unwrap());
    let u: Vec<f64> = (0..100).map(|k| if k < 25 { 0.712 } else { 0.714 }).collect();
    let run = |nominal: &dyn Nominal| {
        let mut simulator = nominal.simulator(known.ts).unwrap();
        let x0: Vec<f64> = simulator.initial().iter().map(|x| x.value).collect();
        let mut y = vec![0.0; 500];
        simulator.simulate(&nominal.model().nominal(), &x0, &u, &mut y);
        y
    };
    let (linear, nonlinear) = (run(&*linear), run(&*nonlinear));
    for (l, n) in linear.iter().zip(&nonlinear) {
        // Fuel moves by 0.3 %, of which the second order is 1e-5, and outputs by up to 0.2 %.
        assert!((l / n - 1.0).abs() < 3e-5, "{l} {n}");
    }
}

/// As a black box it is named with a fifth of the runs of a whole search (503 and more on logs of 400 samples,
/// `docs/results/gap-engine.md`).
#[test]
fn a_wide_nozzle_is_named_with_few_runs() {
    let cause = EngineCause::Health(HealthParameter::NozzleArea, 0.015);
    let known = EngineKnowledge { module_tolerance: 0.0, ..known() };
    let log = engine_log(&known, cause, 300, 3).unwrap();
    let found = diagnose_with_few_runs(&known, engine_effects(), &log).unwrap().unwrap();
    assert_eq!(Answer::of(&found.diagnosis, cause), Answer::Right);
    let strength = &found.diagnosis.causes[0].parameters[0];
    assert!((strength.value - 0.015).abs() < 3.0 * strength.standard_error);
    assert!(found.runs <= 100.0, "{}", found.runs);
}

#[test]
fn a_worn_compressor_is_named_by_the_nonlinear_simulator() {
    let cause = EngineCause::Health(HealthParameter::HpcEfficiency, -0.015);
    let (answer, _) = find(&known(), false, few(), cause, 300, 1);
    assert!(matches!(answer, Answer::Right | Answer::Tied), "{answer:?}");
}

/// The linear engine is sampled: a sample is its step, and cannot be halved.
#[test]
fn the_linear_engine_blames_nothing_for_its_fuel() {
    let (answer, diagnosis) = find(&known(), true, few(), EngineCause::Nothing, 300, 3);
    assert_eq!(answer, Answer::Right, "{:?}", diagnosis.verdict);
    // A standard deviation of 300 samples is 1 ± 0.04, of which the largest of five is within 0.2.
    assert!(diagnosis.refit.gap.iter().all(|gap| *gap < 1.2), "{:?}", diagnosis.refit.gap);
}

/// With the nonlinear engine it is the cause, and its model gets it (`fdiag-cli gap::engine`).
#[test]
fn a_slow_fuel_valve_comes_first_with_the_linear_engine() {
    let (answer, _) = find(&known(), true, few(), EngineCause::FuelLag(0.15), 300, 2);
    // What the linear simulator leaves besides, 1.4 times the noise, is none of these.
    assert!(matches!(answer, Answer::Right | Answer::Tied | Answer::First), "{answer:?}");
}
