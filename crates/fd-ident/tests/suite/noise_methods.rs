//! Which estimates noise pulls away, and whether stated standard errors are true.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
#![allow(clippy::print_stdout, reason = "measured figures are worth seeing")]

use crate::common::{noise, record};
use fd_core::stage::Identifier;
use fd_ident::{
    IdentError,
    arx::{ArxFit, ArxModel, ArxOrders, RecursiveArx, Start},
    extended::{ExtendedLeastSquares, RecursiveArmax},
    instrumental::{InstrumentalVariables, Instruments, IvDesign, RecursiveIv},
    prediction_error::{NoiseStructure, PredictionError},
    random_walk::{KalmanRls, RandomWalkDesign},
    refine::Sriv,
    rls::{RlsDesign, UdRls},
};
use fd_model::{Record, SampleTime};

/// One lag with a pole at 0.8: `μ(k) = 0.8 μ(k−1) + 0.5 u(k−1)`.
const ORDERS: ArxOrders = ArxOrders::new(1, 1, 1);
const TRUTH: [f64; 2] = [-0.8, 0.5];
/// Variance of a number that is uniform in −1 to 1.
const UNIFORM: f64 = 1.0 / 3.0;

fn clean(u: &[f64]) -> Vec<f64> {
    let ts = SampleTime::new(0.02).unwrap();
    let model = ArxModel::new(ORDERS, 1, 1, TRUTH.to_vec(), ts).unwrap();
    let silent = record(1, 1, u.to_vec(), vec![0.0; u.len()]);
    model.simulate_record(&silent, Start::Rest).unwrap()
}

/// A run with noise `C/D e` on the measurement, `e` uniform in `±size`.
fn measured(seed: u64, len: usize, size: f64, c: f64, d: f64) -> Record {
    let u = noise(2 * seed, len);
    let e = noise(2 * seed + 1, len);
    let (mut v, mut before) = (0.0, 0.0);
    let mu = clean(&u).into_iter().zip(e).map(|(mu, e)| {
        v = -d * v + size * (e + c * before);
        before = e;
        mu + v
    });
    let mu = mu.collect();
    record(1, 1, u, mu)
}

/// Mean of each parameter over runs, and the standard error of that mean.
fn mean_and_error(runs: &[Vec<f64>]) -> Vec<(f64, f64)> {
    let m = runs.len() as f64;
    (0..runs[0].len())
        .map(|i| {
            let mean = runs.iter().map(|run| run[i]).sum::<f64>() / m;
            let variance = runs.iter().map(|run| (run[i] - mean).powi(2)).sum::<f64>() / (m - 1.0);
            (mean, (variance / m).sqrt())
        })
        .collect()
}

/// The claim of "unbiased": the mean over independent runs lies within 4.5 standard errors of the
/// truth (by chance in one of 150 000 such comparisons), plus `1/N` for the bias of order `1/N`
/// that every consistent estimator may have.
fn assert_unbiased(name: &str, runs: &[Vec<f64>], len: usize) {
    for (i, (mean, error)) in mean_and_error(runs).into_iter().enumerate() {
        let off = (mean - TRUTH[i]).abs();
        let allowed = 4.5 * error + 5.0 / len as f64;
        assert!(off < allowed, "{name}: parameter {i} {mean:.5} ± {error:.5}, off {off:.5}");
    }
}

fn recursively(mut identifier: impl Identifier<f64>, data: &Record) -> Vec<f64> {
    for (u, mu) in data.samples() {
        identifier.update(u, mu);
    }
    identifier.theta().to_vec()
}

/// With white measurement noise of variance σ², least squares tends to
/// `(R + σ² E)⁻¹ R θ`, where only the entry of past `μ` has noise. Here the input is white with
/// variance 1/3, so past `μ` and past input are uncorrelated: `a` is pulled by the factor
/// `r/(r+σ²)` with `r = b²/(1−a²)/3`, and `b` stays.
#[test]
fn least_squares_is_biased_by_as_much_as_theory_says_and_instruments_are_not() {
    let (len, size) = (2000, 0.5);
    let (mut plain, mut rls, mut kalman) = (Vec::new(), Vec::new(), Vec::new());
    let mut unbiased: Vec<(&str, Vec<Vec<f64>>)> = [
        "simulated",
        "delayed inputs",
        "delayed outputs",
        "recursive",
        "SRIV",
        "output error",
        "Box-Jenkins",
        "ARMAX",
        "extended",
        "recursive extended",
    ]
    .map(|name| (name, Vec::new()))
    .to_vec();
    for seed in 0..60 {
        let data = measured(seed, len, size, 0.0, 0.0);
        let fit = |instruments| {
            let iv = InstrumentalVariables::new(ORDERS, instruments);
            iv.fit(&[&data]).unwrap().model.theta().to_vec()
        };
        plain.push(ArxFit::new(ORDERS).fit(&[&data]).unwrap().model.theta().to_vec());
        let kernel = UdRls::<f64>::new(2, &RlsDesign::default()).unwrap();
        rls.push(recursively(RecursiveArx::new(ORDERS, 1, 1, kernel).unwrap(), &data));
        let kernel = KalmanRls::<f64>::new(2, &RandomWalkDesign::default()).unwrap();
        kalman.push(recursively(RecursiveArx::new(ORDERS, 1, 1, kernel).unwrap(), &data));
        let iv = RecursiveIv::new(ORDERS, 1, 1, &IvDesign::default()).unwrap();
        let kernel = UdRls::<f64>::new(3, &RlsDesign::default()).unwrap();
        let extended = RecursiveArmax::new(ORDERS, 1, 1, 1, kernel).unwrap();
        let found = [
            fit(Instruments::default()),
            fit(Instruments::DelayedInputs {}),
            fit(Instruments::DelayedOutputs { lag: 1 }),
            recursively(iv, &data),
            Sriv::new(ORDERS).fit(&[&data]).unwrap().estimate.model.theta().to_vec(),
            pem(NoiseStructure::OutputError, &data),
            pem(NoiseStructure::BoxJenkins { nc: 0, nd: 1 }, &data),
            pem(NoiseStructure::Armax { nc: 1 }, &data),
            ExtendedLeastSquares::new(ORDERS, 1).fit(&[&data]).unwrap().model.theta().to_vec(),
            recursively(extended, &data),
        ];
        for ((_, runs), found) in unbiased.iter_mut().zip(found) {
            runs.push(found);
        }
    }
    let r = UNIFORM * TRUTH[1].powi(2) / (1.0 - TRUTH[0].powi(2));
    let expected = TRUTH[0] * r / (r + size * size * UNIFORM);
    for (name, runs) in [("batch", &plain), ("recursive", &rls), ("Kalman", &kalman)] {
        let (mean, error) = mean_and_error(runs)[0];
        println!("least squares, {name}: a = {mean:.4} ± {error:.4}, theory {expected:.4}");
        assert!((mean - expected).abs() < 4.5 * error + 5.0 / f64::from(2000), "{mean} {expected}");
        assert!((mean - TRUTH[0]).abs() > 30.0 * error);
    }
    for (name, runs) in &unbiased {
        let (mean, error) = mean_and_error(runs)[0];
        println!("{name}: a = {mean:.4} ± {error:.4}");
        // The recursive methods have forgotten their start only in part.
        let effective = if name.starts_with("recursive") { 250 } else { len };
        assert_unbiased(name, runs, effective);
    }
    // Gauss-Newton is efficient, plain instruments are not.
    let spread = |index: usize| mean_and_error(&unbiased[index].1)[0].1;
    assert!(spread(5) < spread(0) && spread(5) < spread(1), "{} {}", spread(5), spread(0));
}

fn pem(noise: NoiseStructure, data: &Record) -> Vec<f64> {
    let fit = PredictionError::new(ORDERS, noise).fit(&[data]).unwrap();
    fit.model.theta().to_vec()
}

/// The sample variance of M runs has a relative standard deviation of √(2/(M−1)) for normal
/// estimates, 0.10 for 200 runs; 4 of these are allowed, plus 5 % for short records.
fn assert_covariance(noise: NoiseStructure, truth: &[f64], c: f64, d: f64) {
    let (mut runs, mut stated) = (Vec::new(), vec![0.0; truth.len()]);
    for seed in 0..200 {
        let data = measured(1000 + seed, 500, 0.4, c, d);
        let estimate = PredictionError::new(ORDERS, noise).from_rest().fit(&[&data]).unwrap();
        let fit = &estimate.channels[0].fit;
        assert!(estimate.channels[0].converged, "{noise:?}, seed {seed}");
        for (sum, error) in stated.iter_mut().zip(fit.standard_errors()) {
            *sum += error.powi(2) / 200.0;
        }
        runs.push(fit.coefficients.clone());
    }
    for (i, (mean, error)) in mean_and_error(&runs).into_iter().enumerate() {
        let ratio = error.powi(2) * 200.0 / stated[i];
        println!("{noise:?} {i}: {mean:.4} for {:.4}, variance / stated {ratio:.2}", truth[i]);
        assert!((ratio - 1.0).abs() < 4.0 * (2.0_f64 / 199.0).sqrt() + 0.05, "{i}: {ratio}");
        assert!((mean - truth[i]).abs() < 4.5 * error + 5.0 / 500.0, "{i}: {mean}");
    }
}

#[test]
fn standard_errors_of_output_error_are_those_of_monte_carlo() {
    assert_covariance(NoiseStructure::OutputError, &[-0.8, 0.5], 0.0, 0.0);
}

#[test]
fn standard_errors_of_box_jenkins_are_those_of_monte_carlo() {
    let noise = NoiseStructure::BoxJenkins { nc: 1, nd: 1 };
    assert_covariance(noise, &[-0.8, 0.5, 0.5, -0.7], 0.5, -0.7);
}

#[test]
fn standard_errors_of_armax_are_those_of_monte_carlo() {
    // C/A on the measurement with C = 1 + 0.4 q⁻¹.
    assert_covariance(NoiseStructure::Armax { nc: 1 }, &[-0.8, 0.5, 0.4], 0.4, -0.8);
}

/// Noise through a slow filter of its own: only a structure that knows it finds the parameters
/// with the least variance; all instruments and output error stay unbiased.
#[test]
fn coloured_noise_is_told_apart_from_the_bias() {
    let (mut oe, mut bj, mut iv, mut els) = (vec![], vec![], vec![], vec![]);
    for seed in 0..60 {
        let data = measured(500 + seed, 1500, 0.3, 0.0, -0.9);
        oe.push(pem(NoiseStructure::OutputError, &data));
        bj.push(pem(NoiseStructure::BoxJenkins { nc: 0, nd: 1 }, &data));
        let simulated = InstrumentalVariables::new(ORDERS, Instruments::default());
        iv.push(simulated.fit(&[&data]).unwrap().model.theta().to_vec());
        els.push(ArxFit::new(ORDERS).fit(&[&data]).unwrap().model.theta().to_vec());
    }
    assert_unbiased("output error", &oe, 1500);
    assert_unbiased("Box-Jenkins", &bj, 1500);
    assert_unbiased("instruments", &iv, 1500);
    let (mean, error) = mean_and_error(&els)[0];
    assert!((mean - TRUTH[0]).abs() > 10.0 * error, "least squares {mean} ± {error}");
    let spread = |runs: &[Vec<f64>]| mean_and_error(runs)[0].1;
    println!("spread of a: OE {:.5}, BJ {:.5}, IV {:.5}", spread(&oe), spread(&bj), spread(&iv));
    // The maximum of the likelihood has the least variance of all. A ratio of 1.25 or more in the
    // standard deviations of 60 runs each is beyond the 95 % point of F(59, 59).
    assert!(1.25 * spread(&bj) < spread(&oe));
}

#[test]
fn exact_data_with_holes_over_several_records_give_the_exact_model() {
    let orders = ArxOrders::new(2, 2, 1).with_offset();
    let ts = SampleTime::new(0.02).unwrap();
    let theta = vec![-1.6, 0.65, 0.2, -0.1, 0.03, 0.05, 0.02];
    let model = ArxModel::new(orders, 2, 1, theta.clone(), ts).unwrap();
    let make = |seed: u64, skip: usize| {
        let u = noise(seed, 600);
        let silent = record(2, 1, u.clone(), vec![0.0; 300]);
        let mu = model.simulate_record(&silent, Start::Rest).unwrap();
        let mut data = record(2, 1, u, mu).slice(skip, 300);
        for k in [40, 41, 97] {
            data.y_mut(k)[0] = f64::NAN;
        }
        data
    };
    // The first record starts at rest, the second one does not.
    let records = [make(1, 0), make(2, 60)];
    for noise in [
        NoiseStructure::OutputError,
        NoiseStructure::BoxJenkins { nc: 1, nd: 1 },
        NoiseStructure::Armax { nc: 0 },
    ] {
        let fit = PredictionError::new(orders, noise).fit(&records).unwrap();
        for (found, truth) in fit.model.theta().iter().zip(&theta) {
            // The search stops at errors of 10 ε of the signal; cond² of this data is below 1e6.
            assert!((found - truth).abs() < 1e-8, "{noise:?}: {found} {truth}");
        }
    }
    for instruments in [Instruments::default(), Instruments::DelayedInputs {}] {
        let fit = InstrumentalVariables::new(orders, instruments).fit(&records).unwrap();
        for (found, truth) in fit.model.theta().iter().zip(&theta) {
            assert!((found - truth).abs() < 1e-8, "{instruments:?}: {found} {truth}");
        }
    }
}

#[test]
fn a_searched_model_is_stable_even_when_its_start_is_not() {
    // A ramp that a short record takes for an unstable lag.
    let u = noise(9, 40);
    let mu: Vec<f64> = (0..40).zip(&u).map(|(k, u)| 1.06_f64.powi(k) + 0.1 * u).collect();
    let data = record(1, 1, u, mu);
    let plain = ArxFit::new(ORDERS).fit(&[&data]).unwrap().model;
    assert!(!plain.is_stable().unwrap());
    for noise in [NoiseStructure::OutputError, NoiseStructure::Armax { nc: 1 }] {
        let fit = PredictionError::new(ORDERS, noise).fit(&[&data]).unwrap();
        assert!(fit.model.is_stable().unwrap(), "{noise:?} {:?}", fit.model.theta());
    }
}

#[test]
fn too_little_data_and_silent_inputs_are_refused() {
    let short = measured(1, 6, 0.1, 0.0, 0.0);
    let error = PredictionError::box_jenkins(ORDERS, 2, 2).fit(&[&short]).unwrap_err();
    assert!(matches!(error, IdentError::TooFewRows { .. }), "{error}");
    let silent = record(1, 1, vec![0.0; 100], noise(3, 100));
    for error in [
        PredictionError::output_error(ORDERS).fit(&[&silent]).unwrap_err(),
        InstrumentalVariables::new(ORDERS, Instruments::default()).fit(&[&silent]).unwrap_err(),
        ExtendedLeastSquares::new(ORDERS, 1).fit(&[&silent]).unwrap_err(),
    ] {
        assert!(matches!(error, IdentError::RankDeficient { .. }), "{error}");
    }
}
