//! Linear models as equations simulate as the matrices do.

use faer::Mat;
use fd_model::{
    Channel, ChannelScale, Continuous, Discrete, SampleTime, StateSpace,
    file::{LinearModel, LinearSystem},
};
use fd_sim::{
    model::{LinearOptions, Mistake, Model},
    simulate::{BlackBox, EquationSimulator, Outcome, Simulator},
};
use proptest::prelude::*;

const SAMPLES: usize = 60;

/// Entries in -1 .. 1, about a third of them zero.
fn entries(count: usize) -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(prop_oneof![1 => Just(0.0), 2 => -1.0..1.0], count)
}

fn channels(prefix: &str, count: usize) -> Vec<Channel> {
    Channel::numbered(prefix, count)
}

/// A linear model with operating points and scales on every second channel.
fn with_scales(system: LinearSystem) -> LinearModel {
    let [_, _, c, d] = system.matrices();
    let (nu, ny) = (d.ncols(), c.nrows());
    let mut model = LinearModel::new(system, channels("u", nu), channels("y", ny)).unwrap();
    for (i, channel) in model.inputs.iter_mut().chain(&mut model.outputs).enumerate() {
        if i % 2 == 0 {
            channel.scale = ChannelScale { offset: 0.5 + i as f64, scale: Some(2.0) };
        }
    }
    model
}

/// The deviations that the matrices see for physical inputs, and physical outputs for theirs.
fn by_the_matrices(linear: &LinearModel, reference: &mut BlackBox, u: &[f64]) -> Vec<f64> {
    let (nu, ny) = (linear.inputs.len(), linear.outputs.len());
    let seen: Vec<f64> =
        u.iter().enumerate().map(|(i, u)| linear.inputs[i % nu].scale.scaled(*u)).collect();
    let x0 = vec![0.0; reference.initial().len()];
    let mut y = vec![0.0; SAMPLES * ny];
    reference.simulate(&[], &x0, &seen, &mut y);
    let physical = |(i, y): (usize, &f64)| {
        let scale = linear.outputs[i % ny].scale;
        scale.offset + scale.scale.unwrap_or(1.0) * y
    };
    y.iter().enumerate().map(physical).collect()
}

fn by_the_equations(model: &Model, u: &[f64]) -> Vec<f64> {
    let mut simulator = EquationSimulator::<f64>::new(model).unwrap();
    let mut y = vec![0.0; SAMPLES * model.outputs.len()];
    let (theta, x0) = (model.nominal(), model.initial());
    assert_eq!(Simulator::simulate(&mut simulator, &theta, &x0, u, &mut y), Outcome::Complete);
    y
}

fn compare(linear: &LinearModel, reference: &mut BlackBox, u: &[f64], tolerance: f64) {
    let ts = reference.ts();
    for tolerances in [0.0, 0.03] {
        let options = LinearOptions {
            gain_tolerance: tolerances,
            time_tolerance: tolerances,
            ..LinearOptions::default()
        };
        let model = Model::from_linear(linear, ts, &options).unwrap();
        assert_eq!(model.to_string().parse::<Model>().unwrap(), model);
        let uncertain = if tolerances > 0.0 { 1 + linear.outputs.len() } else { 0 };
        assert_eq!(model.parameters.len(), uncertain);
        let expected = by_the_matrices(linear, reference, u);
        let size = expected.iter().fold(1.0_f64, |m, y| m.max(y.abs()));
        for (y, expected) in by_the_equations(&model, u).iter().zip(&expected) {
            assert!((y - expected).abs() <= tolerance * size, "{y} is not {expected}\n{model}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(32)
    })]

    #[test]
    fn a_discrete_model_is_the_same(
        nx in 1..5_usize, nu in 1..3_usize, ny in 1..4_usize,
        entries in entries(100), u in prop::collection::vec(-1.0..1.0, 2 * SAMPLES),
    ) {
        let mut next = entries.into_iter().cycle();
        let mut matrix = |rows: usize, cols: usize, size: f64| {
            Mat::from_fn(rows, cols, |_, _| size * next.next().unwrap())
        };
        let ts = SampleTime::new(0.1).unwrap();
        // Rows with a sum below 0.9 make a stable model.
        let (a, b) = (matrix(nx, nx, 0.9 / nx as f64), matrix(nx, nu, 1.0));
        let (c, d) = (matrix(ny, nx, 1.0), matrix(ny, nu, 1.0));
        let system = StateSpace::new(a, b, c, d, Discrete { ts }).unwrap();
        let mut reference =
            BlackBox::discrete(&system, channels("u", nu), channels("y", ny)).unwrap();
        let linear = with_scales(LinearSystem::Discrete(system));
        // Sums of up to 7 products, contracted by 0.9 per sample: 7 * eps / (1 - 0.9) = 2e-14.
        compare(&linear, &mut reference, &u[..nu * SAMPLES], 1e-13);
    }

    #[test]
    fn a_continuous_model_is_the_same(
        nx in 1..5_usize, nu in 1..3_usize, ny in 1..4_usize,
        entries in entries(100), u in prop::collection::vec(-1.0..1.0, 2 * SAMPLES),
    ) {
        let mut next = entries.into_iter().cycle();
        let mut matrix = |rows: usize, cols: usize, size: f64| {
            Mat::from_fn(rows, cols, |_, _| size * next.next().unwrap())
        };
        let ts = SampleTime::new(0.02).unwrap();
        // Dominated by a diagonal of -2: stable, and at most 3 rad/s.
        let mut a = matrix(nx, nx, 1.0 / nx as f64);
        (0..nx).for_each(|i| a[(i, i)] -= 2.0);
        let (b, c, d) = (matrix(nx, nu, 1.0), matrix(ny, nx, 1.0), matrix(ny, nu, 1.0));
        let system = StateSpace::new(a, b, c, d, Continuous).unwrap();
        let mut reference =
            BlackBox::continuous(&system, channels("u", nu), channels("y", ny), ts).unwrap();
        let linear = with_scales(LinearSystem::Continuous(system));
        // Runge-Kutta with h |lambda| <= 0.06: an error of (h lambda)^5/120 = 6e-9 per step and
        // at most 1/(h lambda) steps are remembered.
        compare(&linear, &mut reference, &u[..nu * SAMPLES], 2e-7);
    }
}

#[test]
fn names_units_noise_and_sample_times() {
    let ts = SampleTime::new(0.1).unwrap();
    let one = |value: f64| Mat::from_fn(1, 1, |_, _| value);
    let system = StateSpace::new(one(0.5), one(1.0), one(1.0), one(0.0), Discrete { ts }).unwrap();
    let system = LinearSystem::Discrete(system);
    let (u, y) = (Channel::new("x1", "V"), Channel::new("y", ""));
    let mut linear = LinearModel::new(system, vec![u], vec![y.clone()]).unwrap();
    let options = LinearOptions { noise: vec![Some(0.1)], ..LinearOptions::default() };
    let model = Model::from_linear(&linear, ts, &options).unwrap();
    // The name of the input is taken; states make way.
    assert_eq!(model.states[0].name, "x1_2");
    assert_eq!((model.outputs[0].unit.as_str(), model.outputs[0].noise), ("1", Some(0.1)));

    let other = SampleTime::new(0.2).unwrap();
    let error = Model::from_linear(&linear, other, &options).unwrap_err();
    assert!(matches!(*error.mistake, Mistake::Number { found: 0.1, .. }), "{error}");
    linear.inputs[0].channel.name = "main fuel".to_owned();
    let error = Model::from_linear(&linear, ts, &options).unwrap_err();
    assert!(matches!(*error.mistake, Mistake::BadName(_)), "{error}");
    linear.inputs[0].channel.name = y.name;
    let error = Model::from_linear(&linear, ts, &options).unwrap_err();
    assert!(matches!(*error.mistake, Mistake::Duplicate { .. }), "{error}");
}
