//! Options beyond plain least squares: what each of them mends, and what it must not break.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use crate::common::{noise, record};
use fd_ident::{
    IdentError,
    arx::{ArxFit, ArxModel, ArxOrders, Start},
    refine::{Prefilter, Sriv, decimate},
};
use fd_model::{Record, SampleTime};

const ORDERS: ArxOrders = ArxOrders::new(2, 2, 1);

/// Poles at 0.9 and 0.8, slow against the sampling as biases of observers are.
fn truth() -> ArxModel {
    let theta = vec![-1.7, 0.72, 0.2, 0.1];
    ArxModel::new(ORDERS, 1, 1, theta, SampleTime::new(0.02).unwrap()).unwrap()
}

/// Response to a random staircase, with white *measurement* noise.
fn data(seed: u64, len: usize, size: f64) -> Record {
    let levels = noise(seed, len);
    let u: Vec<f64> = (0..len).map(|k| levels[k / 5]).collect();
    let clean =
        truth().simulate_record(&record(1, 1, u.clone(), vec![0.0; len]), Start::Rest).unwrap();
    let mu = clean.iter().zip(noise(seed + 1, len)).map(|(mu, e)| mu + size * e).collect();
    record(1, 1, u, mu)
}

fn distance(model: &ArxModel) -> f64 {
    truth().response_distance(model)
}

#[test]
fn instrumental_variables_remove_the_bias_of_least_squares() {
    let (mut plain, mut refined) = (0.0, 0.0);
    for seed in 0..10 {
        let data = data(100 * seed, 3000, 0.5);
        plain += distance(&ArxFit::new(ORDERS).fit(&[&data]).unwrap().model) / 10.0;
        let result = Sriv::new(ORDERS).fit(&[&data]).unwrap();
        assert!(result.converged, "{seed}: {} rounds", result.rounds);
        refined += distance(&result.estimate.model) / 10.0;
    }
    println!("response distance: least squares {plain:.3}, SRIV {refined:.3}");
    assert!(refined < 0.1 && plain > 4.0 * refined, "{plain} {refined}");
}

#[test]
fn a_prefilter_shrinks_the_bias_and_keeps_exact_data_exact() {
    let filter = Prefilter::low_pass(2, 10.0, SampleTime::new(0.02).unwrap()).unwrap();
    let mut exact = data(3, 500, 0.0);
    exact.y_mut(200)[0] = f64::NAN;
    let smooth = ArxFit::new(ORDERS).with_prefilter(filter);
    let model = smooth.fit(&[exact.slice(50, 500)]).unwrap().model;
    assert!(distance(&model) < 1e-8, "{}", distance(&model));

    let noisy = data(3, 3000, 0.5);
    let plain = ArxFit::new(ORDERS).fit(&[&noisy]).unwrap().model;
    let filtered = smooth.fit(&[&noisy]).unwrap().model;
    println!(
        "response distance: plain {:.3}, prefiltered {:.3}",
        distance(&plain),
        distance(&filtered)
    );
    assert!(distance(&filtered) < 0.5 * distance(&plain));
}

#[test]
fn refinement_of_exact_data_stays_exact_with_holes() {
    let mut exact = data(3, 500, 0.0);
    exact.y_mut(200)[0] = f64::NAN;
    let result = Sriv::new(ORDERS).fit(&[&exact]).unwrap();
    assert!(result.converged && distance(&result.estimate.model) < 1e-8);
}

#[test]
fn unstable_filters_are_refused() {
    let error = Prefilter::new(&[1.0], &[-1.1]).unwrap_err();
    assert!(matches!(error, IdentError::Setting { found, .. } if (found - 1.1).abs() < 1e-12));
}

#[test]
fn a_decimated_model_has_the_same_gain_and_slower_poles() {
    let levels = noise(8, 400);
    let u: Vec<f64> = (0..4000).map(|k| levels[k / 10]).collect();
    let mu = truth().simulate_record(&record(1, 1, u.clone(), vec![0.0; 4000]), Start::Rest);
    let slow = decimate(&record(1, 1, u, mu.unwrap()), 10).unwrap();
    assert!((slow.ts().seconds() - 0.2).abs() < 1e-15);
    let model = ArxFit::new(ArxOrders::paper(2)).fit(&[slow]).unwrap().model;
    // Averages over a held input obey an exact equation of the same order: poles to the tenth.
    let mut poles: Vec<f64> = model.poles(0).unwrap().iter().map(|pole| pole.re).collect();
    poles.sort_by(f64::total_cmp);
    assert!((poles[1] - 0.9_f64.powi(10)).abs() < 1e-6, "{poles:?}");
    assert!((poles[0] - 0.8_f64.powi(10)).abs() < 1e-6, "{poles:?}");
    assert!((model.dc_gain(0, 0) - truth().dc_gain(0, 0)).abs() < 1e-6);
}
