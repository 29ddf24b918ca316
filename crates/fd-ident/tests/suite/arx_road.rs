//! From data to a frozen model: batch, recursive and simulation agree on one difference equation.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use crate::common::{bits, noise, record};
use fd_core::{
    Snapshot,
    stage::{BiasModel, Identifier, Stage},
};
use fd_ident::{
    IdentError,
    arx::{ArxFit, ArxModel, ArxOrders, ArxSimulator, RecursiveArx},
    rls::{RlsDesign, UdRls},
};
use fd_model::{Record, SampleTime};

const ORDERS: ArxOrders = ArxOrders { na: 2, nb: 2, delay: 1, offset: true };
/// Two channels, two inputs: a1 a2, b0 (u1 u2), b1 (u1 u2), c.
const THETA: [f64; 14] =
    [-1.2, 0.4, 0.5, -0.3, 0.2, 0.1, 0.05, -0.5, 0.3, -0.2, 0.7, 0.1, 0.4, -0.02];

fn model() -> ArxModel {
    ArxModel::new(ORDERS, 2, 2, THETA.to_vec(), SampleTime::new(0.02).unwrap()).unwrap()
}

/// Noise-free response from rest to random inputs.
fn response(len: usize) -> Record {
    let u = noise(1, 2 * len);
    let mut simulator: ArxSimulator<f64> = model().freeze().unwrap();
    let mut mu = vec![0.0; 2 * len];
    for (u, mu) in u.chunks_exact(2).zip(mu.chunks_exact_mut(2)) {
        simulator.simulate(u, mu);
    }
    record(2, 2, u, mu)
}

fn identifier() -> RecursiveArx<f64> {
    let design = RlsDesign { prior_variance: 1e9, ..RlsDesign::default() };
    let kernel = UdRls::<f64>::new(ORDERS.parameters(2), &design).unwrap();
    RecursiveArx::new(ORDERS, 2, 2, kernel).unwrap()
}

#[test]
fn batch_and_recursive_find_the_true_parameters() {
    let data = response(300);
    let estimate = ArxFit::new(ORDERS).fit(std::slice::from_ref(&data)).unwrap();
    // Noise-free: error of order eps times the condition, which is below 100 here.
    for (found, truth) in estimate.model.theta().iter().zip(THETA) {
        assert!((found - truth).abs() < 1e-12, "{found} {truth}");
    }
    let mut identifier = identifier();
    data.samples().for_each(|(u, mu)| identifier.update(u, mu));
    // The prior of variance 1e9 pulls by about 1 / (1e9 * 300 * 0.3).
    for (found, truth) in identifier.theta().iter().zip(THETA) {
        assert!((found - truth).abs() < 1e-9, "{found} {truth}");
    }
    assert!(!identifier.guard().acted());
    let mut variance = [0.0; 14];
    identifier.variance_into(&mut variance);
    for (channel, fit) in estimate.channels.iter().enumerate() {
        for i in 0..7 {
            let (found, batch) = (variance[7 * channel + i], fit.inverse_gram[(i, i)]);
            assert!((found - batch).abs() < 1e-6 * batch, "{found} {batch}");
        }
    }
}

#[test]
fn the_true_model_predicts_and_simulates_without_error() {
    let data = response(200);
    let mut simulator: ArxSimulator<f64> = model().freeze().unwrap();
    let mut predictor = simulator.clone();
    let (mut simulated, mut predicted) = ([0.0; 2], [0.0; 2]);
    for (u, mu) in data.samples() {
        simulator.simulate(u, &mut simulated);
        predictor.predict(u, mu, &mut predicted);
        // Same operations on same numbers: equal to the bit.
        assert_eq!(bits(&simulated), bits(mu));
        assert_eq!(bits(&predicted), bits(mu));
    }
}

#[test]
fn observing_the_past_starts_a_simulation_without_transient() {
    let data = response(100);
    let mut simulator: ArxSimulator<f64> = model().freeze().unwrap();
    let mut mu_hat = [0.0; 2];
    for (k, (u, mu)) in data.samples().enumerate() {
        if k < 50 {
            simulator.observe(u, mu);
        } else {
            simulator.simulate(u, &mut mu_hat);
            assert_eq!(bits(&mu_hat), bits(mu));
        }
    }
}

#[test]
fn a_fault_does_not_leak_into_a_simulation_but_into_a_prediction() {
    let data = response(100);
    let mut simulator: ArxSimulator<f64> = model().freeze().unwrap();
    let mut predictor = simulator.clone();
    let (mut simulated, mut predicted) = ([0.0; 2], [0.0; 2]);
    for (k, (u, mu)) in data.samples().enumerate() {
        let fault = if k < 50 { 0.0 } else { 1.0 };
        let r = [mu[0] + fault, mu[1]];
        simulator.simulate(u, &mut simulated);
        predictor.predict(u, &r, &mut predicted);
        assert_eq!(bits(&simulated), bits(mu));
        // One sample after its start the fault is in the regressor with weight −a₁ = 1.2.
        let leak = if k <= 50 {
            0.0
        } else if k == 51 {
            1.2
        } else {
            1.2 - 0.4
        };
        assert!((predicted[0] - mu[0] - leak).abs() < 1e-14);
    }
}

#[test]
fn reset_and_restore_give_the_same_future_to_the_bit() {
    let data = response(120);
    let mut identifier = identifier();
    let mut other = identifier.clone();
    let run = |identifier: &mut RecursiveArx<f64>, from: usize, to: usize| {
        (from..to).for_each(|k| identifier.update(data.u(k), data.y(k)));
        identifier.theta().to_vec()
    };
    run(&mut identifier, 0, 60);
    let snapshot = Snapshot::of(&mut identifier);
    let end = run(&mut identifier, 60, 120);
    snapshot.restore(&mut other).unwrap();
    assert_eq!(run(&mut other, 60, 120), end);
    identifier.reset();
    assert_eq!(run(&mut identifier, 0, 120), end);

    let mut simulator = ArxSimulator::<f64>::new(ORDERS, 2, 2).unwrap();
    simulator.load(&THETA);
    let mut restored = ArxSimulator::<f64>::new(ORDERS, 2, 2).unwrap();
    let mut mu = [[0.0; 2]; 2];
    (0..60).for_each(|k| simulator.simulate(data.u(k), &mut mu[0]));
    Snapshot::of(&mut simulator).restore(&mut restored).unwrap();
    for k in 60..120 {
        simulator.simulate(data.u(k), &mut mu[0]);
        restored.simulate(data.u(k), &mut mu[1]);
        assert_eq!(bits(&mu[0]), bits(&mu[1]));
    }
    // Loaded parameters are memory, frozen ones are design.
    simulator.reset();
    assert_eq!(simulator.theta(), [0.0; 14]);
    let mut frozen: ArxSimulator<f64> = model().freeze().unwrap();
    frozen.reset();
    assert_eq!(frozen.theta(), THETA);
}

#[test]
fn several_records_are_stacked_and_missing_samples_skipped() {
    let data = response(120);
    let fit = ArxFit::new(ORDERS);
    // A hole in input 1 at sample 60 removes the targets that look back on it: 61 and 62, and
    // 60 itself does not use u(60) for delay 1.
    let u: Vec<f64> =
        (0..240).map(|i| if i == 120 { f64::NAN } else { data.u(i / 2)[i % 2] }).collect();
    let y: Vec<f64> = (0..240).map(|i| data.y(i / 2)[i % 2]).collect();
    let holed = fit.fit(&[record(2, 2, u, y)]).unwrap();
    let pieces = fit.fit(&[data.slice(0, 61), data.slice(61, 120)]).unwrap();
    assert_eq!(holed.channels[0].rows, 116);
    // Both use the rows up to 60 and those from 63 on.
    assert_eq!(holed, pieces);
}

#[test]
fn bad_data_are_named() {
    let flat = record(1, 1, vec![1.0; 50], vec![0.0; 50]);
    let error = ArxFit::new(ArxOrders::paper(2)).fit(&[flat]).unwrap_err();
    assert!(matches!(error, IdentError::RankDeficient { rank: 1, parameters: 5, .. }), "{error}");
    let short = record(1, 1, vec![1.0; 6], vec![0.0; 6]);
    let error = ArxFit::new(ArxOrders::paper(2)).fit(&[short]).unwrap_err();
    assert!(matches!(error, IdentError::TooFewRows { found: 4, .. }), "{error}");
    let none: [Record; 0] = [];
    assert_eq!(ArxFit::new(ORDERS).fit(&none).unwrap_err(), IdentError::NoRecords);
    let (one, two) = (record(1, 1, vec![1.0], vec![0.0]), record(2, 1, vec![1.0; 2], vec![0.0]));
    let error = ArxFit::new(ORDERS).fit(&[one, two]).unwrap_err();
    assert_eq!(error.to_string(), "record 1: number of inputs is 2, but record 0 has 1");
    let kernel = UdRls::<f64>::new(4, &RlsDesign::default()).unwrap();
    let error = RecursiveArx::new(ArxOrders::paper(2), 1, 1, kernel).unwrap_err();
    assert_eq!(error.to_string(), "parameters of the kernel must be 5x1, got 4x1");
}
