//! Detectors: published run lengths and quantiles, invariances, memory.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use fd_compensate::{
    DrivenRows, SampleRows,
    detect::{
        ChiSquare, Cusum, DetectorError, Magnitude, Norm, Spread, Standardizer, chi_square,
        cusum::{average_run_length, threshold_for},
    },
    testing::every_detector,
};
use fd_core::{
    Scalar,
    stage::{Detector, Verdict},
    testing::memory,
};
use proptest::prelude::*;
use rand::{Rng, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

fn normal(random: &mut impl Rng) -> f64 {
    StandardNormal.sample(random)
}

/// Average run lengths of the two-sided sum with k = 0.5, h = 4, to the printed digits.
#[test]
fn cusum_run_lengths_agree_with_the_published_table() {
    let table = [
        (0.0, 167.68),
        (0.25, 74.22),
        (0.5, 26.63),
        (0.75, 13.29),
        (1.0, 8.38),
        (1.5, 4.75),
        (2.0, 3.34),
        (2.5, 2.62),
        (3.0, 2.19),
        (4.0, 1.71),
    ];
    for (shift, printed) in table {
        let computed = average_run_length(4.0, 0.5, shift).unwrap();
        assert!((computed - printed).abs() <= 0.005, "shift {shift}: {computed} for {printed}");
        let mirrored = average_run_length(4.0, 0.5, -shift).unwrap();
        assert!((mirrored / computed - 1.0).abs() < 1e-12, "the two sides are alike");
    }
}

/// With h → 0 the sum alarms when |z| > k: a Shewhart chart, 370.398 samples for three sigma.
#[test]
fn cusum_without_memory_is_a_shewhart_chart() {
    let computed = average_run_length(1e-9, 3.0, 0.0).unwrap();
    assert!((computed - 370.398).abs() < 5e-4, "{computed}");
}

#[test]
fn cusum_threshold_inverts_the_run_length_or_says_why_not() {
    for wanted in [10.0, 370.0, 1e6] {
        let h = threshold_for(wanted, 0.5).unwrap();
        // Rounding of the system is amplified by its condition, about the run length.
        let tolerance = 1e-13 * wanted + 1e-11;
        assert!((average_run_length(h, 0.5, 0.0).unwrap() / wanted - 1.0).abs() < tolerance);
    }
    assert!(matches!(threshold_for(1.0, 0.5), Err(DetectorError::Parameter { .. })));
    assert!(matches!(threshold_for(1e13, 0.5), Err(DetectorError::Parameter { .. })));
    assert!(matches!(average_run_length(-1.0, 0.5, 0.0), Err(DetectorError::Parameter { .. })));
}

#[test]
fn the_running_cusum_has_the_computed_run_length() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(62);
    for shift in [0.0, 1.0] {
        let exact = average_run_length(4.0, 0.5, shift).unwrap();
        let unit = Standardizer::new(&[0.0], &[1.0]).unwrap();
        let mut detector = Cusum::new(unit, 0.5, 4.0).unwrap();
        let runs = 20_000;
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..runs {
            fd_core::stage::Stage::<f64>::reset(&mut detector);
            let mut length = 1.0;
            while !detector.update(&[], &[shift + normal(&mut random)]).alarm() {
                length += 1.0;
            }
            sum += length;
            squares += length * length;
        }
        let mean = sum / f64::from(runs);
        let error = ((squares / f64::from(runs) - mean * mean) / f64::from(runs)).sqrt();
        // Four standard errors: fails once in 16 000 seeds if the code is right.
        assert!((mean - exact).abs() < 4.0 * error, "{mean} for {exact} (error {error})");
    }
}

#[test]
fn chi_square_thresholds_agree_with_the_published_quantiles() {
    for (channels, window, printed) in [(1, 1, 10.82757), (2, 1, 13.81551), (1, 5, 20.51501)] {
        let computed = chi_square::threshold(channels, window, 1e-3).unwrap();
        assert!((computed - printed).abs() <= 0.5e-5 + 1e-9, "{computed} for {printed}");
    }
    assert!(chi_square::threshold(0, 1, 1e-3).is_err());
    assert!(chi_square::threshold(1, 1, 0.0).is_err());
}

/// "Slightly larger than the largest magnitude": nothing of the fault-free record alarms, and the
/// largest sample does at a slightly lower threshold.
#[test]
fn the_papers_threshold_lies_just_above_the_fault_free_record() {
    let values = correlated(500, 4);
    let rows = SampleRows::new(2, &values).unwrap();
    for norm in [Norm::Max, Norm::Euclidean, Norm::Sum] {
        let mut detector = Magnitude::<f64>::above_fault_free_norm(norm, rows, 0.0).unwrap();
        assert!(!rows.iter().any(|r| detector.update(&[], r).alarm()));
        let lower = detector.threshold() * (1.0 - 1e-9);
        let mut lower = detector.with_threshold(lower).unwrap();
        assert!(rows.iter().any(|r| lower.update(&[], r).alarm()));
    }
}

/// Correlated channels in very different units.
fn correlated(n: usize, seed: u64) -> Vec<f64> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    (0..n)
        .flat_map(|_| {
            let (a, b) = (normal(&mut random), normal(&mut random));
            [1.0 + a, 1e6 * (0.9 * a + 0.3 * b)]
        })
        .collect()
}

#[test]
fn chi_square_keeps_its_rate_on_white_correlated_channels() {
    let fitted = correlated(50_000, 1);
    for window in [1, 10] {
        let threshold = chi_square::threshold(2, window, 0.01).unwrap();
        let rows = SampleRows::new(2, &fitted).unwrap();
        let mut detector = ChiSquare::<f64>::from_fault_free(rows, window, threshold).unwrap();
        let n = 50_000;
        let fresh = correlated(n, 2);
        let alarms = fresh.chunks(2).filter(|r| detector.update(&[], r).alarm()).count();
        // Binomial error sqrt(n p) = 22, times sqrt(window) at most for overlapping windows; 4 of them
        // and 1 % for the covariance estimated from 50 000 samples.
        let tolerance = 4.0 * (500.0 * window as f64).sqrt() + 20.0;
        assert!((alarms as f64 - 500.0).abs() < tolerance, "window {window}: {alarms}");
    }
}

#[test]
fn a_singular_covariance_names_its_channel() {
    let values: Vec<f64> =
        correlated(100, 3).chunks(2).flat_map(|r| [r[0], r[1], r[0] + r[1]]).collect();
    let rows = SampleRows::new(3, &values).unwrap();
    let error = ChiSquare::<f64>::from_fault_free(rows, 1, 1.0).unwrap_err();
    assert_eq!(error, DetectorError::SingularCovariance { channel: 2 });
    let constant: Vec<f64> = (0..100).flat_map(|k| [f64::from(k), 3.0]).collect();
    let rows = SampleRows::new(2, &constant).unwrap();
    let error = ChiSquare::<f64>::from_fault_free(rows, 1, 1.0).unwrap_err();
    assert_eq!(error, DetectorError::ConstantChannel { channel: 1, samples: 100 });
}

#[test]
fn a_median_spread_is_deaf_to_outliers() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
    let mut values: Vec<f64> = (0..10_000).map(|_| normal(&mut random)).collect();
    values[..100].fill(1e6);
    let rows = SampleRows::new(1, &values).unwrap();
    let robust =
        Standardizer::<f64>::from_fault_free(rows, Spread::MedianAbsoluteDeviation).unwrap();
    let z = robust.values(&[2.0]).next().unwrap();
    // 1 % of outliers shift median and MAD by about 1.3 %, sampling by as much.
    assert!((z - 2.0).abs() < 0.1, "{z}");
}

/// Single and double precision decide alike, but for statistics within rounding of the threshold.
#[test]
fn single_precision_decides_alike() {
    let values = correlated(2000, 6);
    let rows = SampleRows::new(2, &values).unwrap();
    let u = input(2000);
    let healthy = DrivenRows::new(SampleRows::new(1, &u).unwrap(), rows).unwrap();
    let (doubles, singles) = (every_detector(healthy).unwrap(), every_detector(healthy).unwrap());
    for ((name, mut double), (_, mut single)) in doubles.into_iter().zip(singles) {
        let mut alarms = 0;
        for k in 0..rows.len() {
            // Three times as loud as what it was fitted to.
            let r: Vec<f64> = rows.row(k).iter().map(|v| 3.0 * v).collect();
            let narrow = |v: &[f64]| v.iter().map(|&v| f32::from_design(v)).collect::<Vec<_>>();
            let double: Verdict<f64> = double.update(healthy.u(k), &r);
            let single: Verdict<f32> = single.update(&narrow(healthy.u(k)), &narrow(&r));
            // Correlation 0.95: whitening amplifies the rounding 6e-8 of values up to 12 about tenfold;
            // a sum keeps it over its memory of some hundred samples.
            let clear = (double.statistic / double.threshold - 1.0).abs() > 1e-3;
            assert!(
                !clear || double.alarm() == single.alarm(),
                "{name}, {k}: {double:?} {single:?}"
            );
            alarms += u32::from(single.alarm());
        }
        assert!(alarms > 10, "{name}: {alarms}");
    }
}

/// An input for the detectors that follow one.
fn input(samples: usize) -> Vec<f64> {
    (0..samples).map(|k| (0.05 * k as f64).sin()).collect()
}

/// Every detector, fitted to healthy rows of the given number of channels.
fn fitted(channels: usize, rows: &[f64]) -> Vec<(&'static str, Box<dyn Detector<f64>>)> {
    let u = input(rows.len() / channels);
    let (u, r) = (SampleRows::new(1, &u).unwrap(), SampleRows::new(channels, rows).unwrap());
    every_detector(DrivenRows::new(u, r).unwrap()).unwrap()
}

fn margin(detector: &mut dyn Detector<f64>, k: usize, r: &[f64]) -> f64 {
    let verdict = detector.update(&[(0.05 * k as f64).sin()], r);
    verdict.statistic / verdict.threshold
}

fn margins(detector: &mut dyn Detector<f64>, rows: &[f64], channels: usize) -> Vec<f64> {
    rows.chunks(channels).enumerate().map(|(k, r)| margin(detector, k, r)).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Other units and another order of the channels leave every statistic where it was.
    #[test]
    fn units_and_order_of_channels_do_not_matter(
        seed in 0_u64..1000,
        scales in prop::array::uniform3(1e-3..1e3_f64),
    ) {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let rows: Vec<[f64; 3]> = (0..300)
            .map(|_| {
                let (a, b, c) = (normal(&mut random), normal(&mut random), normal(&mut random));
                [a, 0.5 * a + b, 0.2 * b + c]
            })
            .collect();
        let other: Vec<f64> = rows
            .iter()
            .flat_map(|r| [r[2] * scales[2], r[0] * scales[0], r[1] * scales[1]])
            .collect();
        let rows = rows.concat();
        for ((name, mut a), (_, mut b)) in
            fitted(3, &rows[..450]).into_iter().zip(fitted(3, &other[..450]))
        {
            let (a, b) = (margins(&mut a, &rows[450..], 3), margins(&mut b, &other[450..], 3));
            for (a, b) in a.iter().zip(&b) {
                // A few hundred roundings in the moments, a condition of about ten.
                prop_assert!((a - b).abs() <= 1e-11 * (1.0 + a.abs()), "{} {} {}", name, a, b);
            }
        }
    }

    /// A higher threshold never alarms where a lower one does not.
    #[test]
    fn alarms_are_monotone_in_the_threshold(seed in 0_u64..1000, low in 0.1..3.0_f64, more in 0.0..3.0_f64) {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut pair = [low, low + more].map(|h| {
            let unit = Standardizer::new(&[0.0], &[1.0]).unwrap();
            Cusum::new(unit, 0.5, h).unwrap()
        });
        for _ in 0..200 {
            let r = [normal(&mut random)];
            let [low, high] = pair.each_mut().map(|d| d.update(&[], &r).alarm());
            prop_assert!(low || !high);
        }
    }

    #[test]
    fn every_detector_obeys_the_law_of_memory(seed in 0_u64..1000, samples in 2_usize..100) {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let rows: Vec<f64> = (0..200).map(|_| normal(&mut random)).collect();
        for ((_, mut one), (_, mut two)) in fitted(2, &rows).into_iter().zip(fitted(2, &rows)) {
            memory(&mut one, &mut two, samples, |detector, k| {
                margin(detector, k, &rows[2 * k..2 * k + 2]).to_bits()
            });
        }
    }
}
