//! Simulations: faults of each site, superposition, divergence.

use faer::mat;
use fd_core::{Heap, IoDims};
use proptest::prelude::*;

use super::*;
use crate::{
    Discrete, Lti, SampleTime, StateSpace,
    fault::{Effect, FaultProfile},
    signal::{ArNoise, Prbs, Step, WhiteNoise},
};

fn ts() -> SampleTime {
    SampleTime::new(0.1).unwrap()
}

fn lag() -> Lti<f64, Heap> {
    let (a, b, c) =
        (mat![[0.8, 0.1], [0.0, 0.5]], mat![[0.0], [1.0]], mat![[1.0, 0.0], [1.0, 1.0]]);
    let model = StateSpace::new(a, b, c, mat![[0.0], [0.5]], Discrete { ts: ts() }).unwrap();
    model.freeze().unwrap()
}

fn outputs() -> Vec<Channel> {
    Channel::numbered("y", 2)
}

fn prbs_inputs() -> Inputs {
    let signal = Prbs::new(6, 0.2, 1.0).seeded(9);
    Inputs::from_signals([(Channel::new("u", "1"), signal)], 200, ts()).unwrap()
}

fn all_outputs(record: &Record) -> Vec<f64> {
    record.samples().flat_map(|(_, y)| y.to_vec()).collect()
}

/// `x⁺ = pole · x + u`, with the pole as a parameter.
#[derive(Clone, Debug)]
struct Movable {
    pole: f64,
}

impl Plant<f64> for Movable {
    fn nx(&self) -> usize {
        1
    }
    fn io(&self) -> IoDims {
        IoDims { nu: 1, ny: 1 }
    }
    fn advance(&self, x: &[f64], u: &[f64], x_next: &mut [f64]) {
        x_next[0] = self.pole * x[0] + u[0];
    }
    fn output(&self, x: &[f64], _u: &[f64], y: &mut [f64]) {
        y[0] = x[0];
    }
}

impl Parameters for Movable {
    fn parameter_names(&self) -> Vec<String> {
        vec!["pole".to_owned()]
    }
    fn parameter(&self, _index: usize) -> f64 {
        self.pole
    }
    fn set_parameter(&mut self, _index: usize, value: f64) {
        self.pole = value;
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn an_additive_sensor_fault_shows_only_on_its_sensor(size in -5.0..5.0_f64, start in 0_u8..200) {
        let start_s = f64::from(start) * 0.1;
        let healthy = Simulation { x0: vec![1.0, -1.0], ..Simulation::default() };
        let mut faulty = healthy.clone();
        faulty.faults = vec![FaultSpec::add(Site::sensor(1), start_s, FaultProfile::abrupt(size))];
        let clean = healthy.run(&lag(), &prbs_inputs(), outputs()).unwrap();
        let dirty = faulty.run(&lag(), &prbs_inputs(), outputs()).unwrap();
        // The same fault laid on the record after the fact.
        let mut after = clean.clone();
        faulty.faults[0].apply_to_record(&mut after).unwrap();
        prop_assert_eq!(&dirty, &after);
        for k in 0..clean.len() {
            let expected = if k >= usize::from(start) { clean.y(k)[1] + size } else { clean.y(k)[1] };
            prop_assert_eq!(dirty.y(k)[0].to_bits(), clean.y(k)[0].to_bits());
            prop_assert_eq!(dirty.y(k)[1].to_bits(), expected.to_bits());
        }
    }

    #[test]
    fn an_actuator_fault_equals_another_input_that_is_not_logged(size in -5.0..5.0_f64) {
        let inputs = prbs_inputs();
        let fault = FaultSpec::add(Site::actuator("u"), 3.0, FaultProfile::abrupt(size));
        let faulty = Simulation { faults: vec![fault.clone()], ..Simulation::default() };
        let mut felt = inputs.values().to_vec();
        fault.apply(&mut felt, 0.0, ts()).unwrap();
        let felt = Inputs::new(inputs.channels().to_vec(), felt, inputs.len(), ts()).unwrap();

        let dirty = faulty.run(&lag(), &inputs, outputs()).unwrap();
        let same = Simulation::default().run(&lag(), &felt, outputs()).unwrap();
        prop_assert_eq!(all_outputs(&dirty), all_outputs(&same));
        prop_assert_eq!(Inputs::from(&dirty), inputs);
    }
}

#[test]
fn a_component_fault_moves_the_parameter() {
    let fault = FaultSpec::new(Site::component("pole"), 0.3, Effect::StuckAt(0.0));
    let simulation = Simulation { faults: vec![fault.clone()], ..Simulation::default() };
    let inputs =
        Inputs::from_signals([(Channel::new("u", "1"), Step::new(1.0, 0.0))], 6, ts()).unwrap();
    let plant = Movable { pole: 0.5 };
    let y = Channel::numbered("y", 1);
    let record = simulation.run_with_parameters(&plant, &inputs, y.clone()).unwrap();
    // The pole is gone in the steps from sample 3 on.
    assert_eq!(all_outputs(&record), [0.0, 1.0, 1.5, 1.75, 1.0, 1.0]);
    assert_eq!(
        simulation.run(&plant, &inputs, y),
        Err(SimulationError::NoParameters { site: fault.site })
    );
}

#[test]
fn noise_is_added_where_it_belongs() {
    let sensor_noise = ArNoise::new(vec![0.5], 0.1, 1);
    let noisy = Simulation {
        output_noise: vec![WhiteNoise::new(0.0, 0).into(), sensor_noise.clone().into()],
        ..Simulation::default()
    };
    let clean = Simulation::default().run(&lag(), &prbs_inputs(), outputs()).unwrap();
    let dirty = noisy.run(&lag(), &prbs_inputs(), outputs()).unwrap();
    let expected = sensor_noise.values(200).unwrap();
    for (k, noise) in expected.iter().enumerate() {
        assert_eq!(dirty.y(k)[0].to_bits(), clean.y(k)[0].to_bits());
        assert_eq!(dirty.y(k)[1].to_bits(), (clean.y(k)[1] + noise).to_bits());
    }

    // White noise through x⁺ = 0.5 x + w has variance σ² / (1 − 0.25).
    let shaken =
        Simulation { state_noise: vec![WhiteNoise::new(1.0, 5).into()], ..Simulation::default() };
    let n = 50_000;
    let idle =
        Inputs::from_signals([(Channel::new("u", "1"), Step::new(0.0, 0.0))], n, ts()).unwrap();
    let record = shaken.run(&Movable { pole: 0.5 }, &idle, Channel::numbered("y", 1)).unwrap();
    let variance = record.output(0).map(|y| y * y).sum::<f64>() / n as f64;
    // Five standard deviations, Σ ρ² = (1 + 0.25) / (1 − 0.25).
    let bound = 5.0 * (2.0 / n as f64 * 1.25 / 0.75).sqrt();
    assert!((variance * 0.75 - 1.0).abs() < bound, "{variance}");
}

#[test]
fn divergence_says_when_and_where() {
    let inputs =
        Inputs::from_signals([(Channel::new("u", "1"), Step::new(1.0, 0.0))], 5000, ts()).unwrap();
    let y = || Channel::numbered("y", 1);
    let limited = Simulation { state_limit: Some(100.0), ..Simulation::default() };
    let error = limited.run(&Movable { pole: 2.0 }, &inputs, y()).unwrap_err();
    // x[k] = 2^k − 1 passes 100 at k = 7.
    assert_eq!(
        error.to_string(),
        format!("the plant diverged at sample 7 ({} s): state 0 is 127", 7.0 * 0.1)
    );
    let error = Simulation::default().run(&Movable { pole: 2.0 }, &inputs, y()).unwrap_err();
    assert!(
        matches!(error, SimulationError::Diverged { k: 1025, value: f64::INFINITY, .. })
            || matches!(error, SimulationError::Diverged { k: 1024, .. }),
        "{error}"
    );
}

#[test]
fn counts_and_missing_inputs_are_checked() {
    let inputs = Inputs::new(Channel::numbered("u", 1), vec![0.0, f64::NAN], 2, ts()).unwrap();
    let error = Simulation::default().run(&lag(), &inputs, outputs()).unwrap_err();
    assert_eq!(error.to_string(), "input `u1` is missing at sample 1 (0.1 s)");

    let run = |simulation: Simulation, outputs| {
        simulation.run(&lag(), &prbs_inputs(), outputs).unwrap_err().to_string()
    };
    let x0 = Simulation { x0: vec![1.0], ..Simulation::default() };
    assert_eq!(run(x0, outputs()), "the plant has 2 states, got 1");
    assert_eq!(
        run(Simulation::default(), Channel::numbered("y", 3)),
        "the plant has 2 outputs, got 3"
    );
    let noise = vec![WhiteNoise::new(1.0, 0).into()];
    let noisy = Simulation { output_noise: noise, ..Simulation::default() };
    assert_eq!(run(noisy, outputs()), "the plant has 2 outputs with noise, got 1");
}

#[test]
fn a_simulation_can_stand_in_a_file() {
    let text = r#"
        x0 = [0.0, 1.0]
        output_noise = [
            { kind = "white-noise", sigma = 0.1, seed = 1 },
            { kind = "ar-noise", coefficients = [0.9], sigma = 0.1, seed = 2 },
        ]

        [[faults]]
        site = { sensor = "y1" }
        start_s = 5.0
        effect.multiply = { kind = "incipient", size = 0.02, rise_s = 10.0 }
    "#;
    let simulation: Simulation = toml::from_str(text).unwrap();
    let record = simulation.run(&lag(), &prbs_inputs(), outputs()).unwrap();
    assert_eq!(record, simulation.run(&lag(), &prbs_inputs(), outputs()).unwrap());
    let again: Simulation = toml::from_str(&toml::to_string(&simulation).unwrap()).unwrap();
    assert_eq!(again, simulation);
}
