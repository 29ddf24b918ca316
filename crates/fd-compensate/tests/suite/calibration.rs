//! Thresholds from fault-free data keep the false-alarm rate they were asked for.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use fd_compensate::{
    SampleRows,
    calibrate::{
        Beyond, CalibrationError, CalibrationPlan, FalseAlarms, autocorrelation_time, calibrate,
    },
    decide::Debouncing,
    detect::{Cusum, Magnitude, Standardizer},
    evaluate::debounced_statistics,
};
use fd_core::stage::Detector;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// First-order autoregressive noise of unit variance, stationary from the start.
fn noise(n: usize, pole: f64, seed: u64) -> Vec<f64> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
    let mut x = draw();
    (0..n)
        .map(|_| {
            let now = x;
            x = pole * x + (1.0 - pole * pole).sqrt() * draw();
            now
        })
        .collect()
}

fn magnitude() -> Magnitude<f64> {
    Magnitude::new(&[1.0], 1.0).unwrap()
}

fn sum() -> Cusum<f64> {
    Cusum::new(Standardizer::new(&[0.0], &[1.0]).unwrap(), 0.5, 4.0).unwrap()
}

#[test]
fn autocorrelation_time_of_known_processes() {
    // AR(1): τ = (1 + a) / (1 − a).
    for (pole, exact) in [(0.0, 1.0), (0.8, 9.0)] {
        let found = autocorrelation_time(&noise(100_000, pole, 11)).unwrap();
        // Relative error about sqrt(2 (2 · 5 + 1) τ / n) (Sokal 1997): 1.5 % and 4.4 %; three of them.
        let tolerance = 3.0 * (22.0 * exact / 1e5_f64).sqrt() * exact;
        assert!((found - exact).abs() < tolerance, "{pole}: {found} for {exact}");
    }
}

/// Share of fresh samples above the threshold, for several records of calibration.
fn rates_on_fresh_data(
    detector: &mut dyn Detector<f64>,
    pole: f64,
    wanted: f64,
    debouncing: Debouncing,
) -> Vec<f64> {
    let n = 20_000;
    (0..6)
        .map(|record| {
            let healthy = noise(n, pole, 100 + record);
            let plan = CalibrationPlan { records: 2, debouncing, ..CalibrationPlan::default() };
            let rows = SampleRows::new(1, &healthy).unwrap();
            let question = FalseAlarms::PerSample { rate: wanted };
            let found = calibrate(detector, rows, question, &plan).unwrap();
            assert!(!found.extrapolated);
            detector.reset();
            let fresh = noise(5 * n, pole, 200 + record);
            let raw: Vec<f64> =
                fresh.iter().map(|&r| detector.update(&[], &[r]).statistic).collect();
            let statistics = debounced_statistics(&raw, debouncing);
            let above = statistics.iter().filter(|&&s| s > found.threshold).count();
            above as f64 / statistics.len() as f64
        })
        .collect()
}

#[test]
fn a_rate_per_sample_is_kept_on_fresh_data() {
    let wanted = 0.01;
    for (pole, worth) in [(0.0, 1.0), (0.8, 9.0)] {
        let rates = rates_on_fresh_data(&mut magnitude(), pole, wanted, Debouncing::default());
        let mean = rates.iter().sum::<f64>() / rates.len() as f64;
        println!("AR({pole}): mean {mean} of {rates:?} for {wanted}");
        // Binomial error of one record, with n / τ independent samples as an upper bound of the
        // clustering; the fresh data, five times as long, add a fifth of the variance.
        let error = (wanted * worth / 20_000.0 * 1.2).sqrt();
        assert!(rates.iter().all(|r| (r - wanted).abs() < 4.0 * error), "{pole}: {rates:?}");
        assert!((mean - wanted).abs() < 4.0 * error / 6.0_f64.sqrt(), "{pole}: {mean}");
    }
}

#[test]
fn a_rate_per_sample_is_kept_with_memory_and_debouncing() {
    let wanted = 0.01;
    let debouncing = Debouncing { raise: 2, out_of: 3, ..Debouncing::default() };
    let rates = rates_on_fresh_data(&mut sum(), 0.0, wanted, debouncing);
    // The sum remembers some ten samples: fifteen times the binomial variance.
    let error = (wanted * 15.0 / 20_000.0 * 1.2).sqrt();
    println!("cusum: {rates:?} for {wanted}");
    assert!(rates.iter().all(|r| (r - wanted).abs() < 4.0 * error), "{rates:?}");
}

#[test]
fn a_probability_per_run_is_kept_on_fresh_runs() {
    for pole in [0.0, 0.8] {
        let healthy = noise(50_000, pole, 7);
        let (probability, samples) = (0.1, 500);
        let mut detector = magnitude();
        let plan = CalibrationPlan { runs: 1000, records: 30, ..CalibrationPlan::default() };
        let rows = SampleRows::new(1, &healthy).unwrap();
        let wanted = FalseAlarms::PerRun { probability, samples };
        let found = calibrate(&mut detector, rows, wanted, &plan).unwrap();
        assert!(found.low < found.threshold && found.threshold < found.high, "{found:?}");
        let runs: u32 = 2000;
        let fresh = noise(samples * runs as usize, pole, 8);
        let alarmed = fresh
            .chunks(samples)
            .filter(|run| run.iter().any(|r| r.abs() > found.threshold))
            .count();
        let rate = alarmed as f64 / f64::from(runs);
        // The record holds about 10.5 independent exceedances of this level, so that the rate of the
        // threshold scatters by a third of itself, the fresh runs by 7 %: four of these at most.
        println!("AR({pole}): {rate} of the runs for {probability}, {found:?}");
        assert!((rate / probability).ln().abs() < 4.0 * 0.32, "{pole}: {rate}, {found:?}");
    }
}

#[test]
fn the_interval_covers_the_true_quantile() {
    // 99 % quantile of |N(0, 1)|.
    let exact = 2.575_829_303_548_901;
    for pole in [0.0, 0.8] {
        let covered = (0..20_u64)
            .filter(|record| {
                let healthy = noise(10_000, pole, 300 + record);
                let rows = SampleRows::new(1, &healthy).unwrap();
                let wanted = FalseAlarms::PerSample { rate: 0.01 };
                let plan = CalibrationPlan::default();
                let found = calibrate(&mut magnitude(), rows, wanted, &plan).unwrap();
                found.low <= exact && exact <= found.high
            })
            .count();
        println!("AR({pole}): {covered} of 20 covered");
        // Confidence 0.9 of 20: 18 on average; fewer than 13 happens once in 400 if it is 0.9.
        assert!(covered >= 13, "{pole}: {covered}");
    }
}

#[test]
fn what_the_record_cannot_resolve_is_refused_or_marked() {
    let healthy = noise(5000, 0.0, 9);
    let rows = SampleRows::new(1, &healthy).unwrap();
    let wanted = FalseAlarms::PerSample { rate: 1e-5 };
    let plan = CalibrationPlan::default();
    let error = calibrate(&mut magnitude(), rows, wanted, &plan).unwrap_err();
    assert!(matches!(error, CalibrationError::Unresolved { .. }), "{error}");

    let plan = CalibrationPlan { beyond: Beyond::Extrapolate, ..plan };
    let found = calibrate(&mut magnitude(), rows, wanted, &plan).unwrap();
    assert!(found.extrapolated);
    // The exponential tail is safe for Gaussian noise (4.42), but not absurd.
    assert!((4.3..7.0).contains(&found.threshold), "{found:?}");

    let run = FalseAlarms::PerRun { probability: 0.01, samples: 5000 };
    let found = calibrate(&mut magnitude(), rows, run, &plan).unwrap();
    // One in 500 000 samples: 4.75 for white Gaussian noise.
    assert!(found.extrapolated && (4.0..7.5).contains(&found.threshold), "{found:?}");
}

#[test]
fn records_that_promise_nothing_are_refused() {
    let ask = |values: &[f64], plan: &CalibrationPlan| {
        let rows = SampleRows::new(1, values).unwrap();
        calibrate(&mut magnitude(), rows, FalseAlarms::PerSample { rate: 0.1 }, plan).unwrap_err()
    };
    let plan = CalibrationPlan::default();
    let drift: Vec<f64> = (0..1000).map(f64::from).collect();
    assert_eq!(ask(&drift, &plan), CalibrationError::Drift { samples: 1000 });
    let short = ask(&noise(30, 0.0, 1), &plan);
    assert!(matches!(short, CalibrationError::TooShort { .. }), "{short}");
    let white = noise(1000, 0.0, 1);
    let confidence = CalibrationPlan { confidence: 1.0, ..plan.clone() };
    assert!(matches!(ask(&white, &confidence), CalibrationError::Parameter { .. }));
    let debouncing = Debouncing { raise: 3, out_of: 2, ..Debouncing::default() };
    let malformed = CalibrationPlan { debouncing, ..plan };
    assert!(matches!(ask(&white, &malformed), CalibrationError::Debouncing(_)));
}

/// Other units of the residual are other units of the threshold, so that decisions stay.
#[test]
fn a_calibrated_threshold_scales_with_the_residual() {
    let healthy = noise(5000, 0.5, 4);
    // A power of two, so that no rounding differs.
    let scaled: Vec<f64> = healthy.iter().map(|r| 1024.0 * r).collect();
    for wanted in [
        FalseAlarms::PerSample { rate: 0.02 },
        FalseAlarms::PerRun { probability: 0.2, samples: 100 },
    ] {
        let ask = |values: &[f64]| {
            let rows = SampleRows::new(1, values).unwrap();
            calibrate(&mut magnitude(), rows, wanted, &CalibrationPlan::default()).unwrap()
        };
        let (plain, scaled) = (ask(&healthy), ask(&scaled));
        for (plain, scaled) in [
            (plain.threshold, scaled.threshold),
            (plain.low, scaled.low),
            (plain.high, scaled.high),
        ] {
            assert_eq!((1024.0 * plain).to_bits(), scaled.to_bits());
        }
    }
}

#[test]
fn the_seed_settles_the_answer() {
    let healthy = noise(5000, 0.5, 4);
    let rows = SampleRows::new(1, &healthy).unwrap();
    let wanted = FalseAlarms::PerRun { probability: 0.2, samples: 100 };
    let ask = |seed| {
        let plan = CalibrationPlan { seed, records: 5, ..CalibrationPlan::default() };
        calibrate(&mut sum(), rows, wanted, &plan).unwrap()
    };
    assert_eq!(ask(1), ask(1));
    assert_ne!(ask(1), ask(2));
}
