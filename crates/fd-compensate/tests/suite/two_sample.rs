//! Two-sample tests: published quantiles, definitions by brute force, rates, what each of them finds.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use fd_compensate::{
    SampleRows,
    detect::{
        TwoSample,
        two_sample::{self, SampleTest, kolmogorov_constant},
    },
};
use fd_core::stage::{Detector, Stage};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

fn white(n: usize, seed: u64) -> Vec<f64> {
    let random = Xoshiro256PlusPlus::seed_from_u64(seed);
    StandardNormal.sample_iter(random).take(n).collect()
}

fn is_near(a: f64, b: f64, relative: f64) -> bool {
    (a - b).abs() <= relative * (1.0 + a.abs().max(b.abs()))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// The Kolmogorov-Smirnov distance against its definition, ties included.
    #[test]
    fn the_distance_of_distributions_is_its_definition(
        reference in prop::collection::vec(-5_i8..5, 3..40),
        values in prop::collection::vec(-6_i8..6, 12..30),
    ) {
        prop_assume!(reference.iter().any(|v| *v != reference[0]));
        let reference: Vec<f64> = reference.into_iter().map(f64::from).collect();
        let rows = SampleRows::new(1, &reference).unwrap();
        let mut detector = TwoSample::<f64>::new(SampleTest::Distribution, rows, 8, 1.0).unwrap();
        let (n, m) = (8.0, reference.len() as f64);
        let values: Vec<f64> = values.into_iter().map(f64::from).collect();
        for k in 0..values.len() {
            let found = detector.update(&[], &[values[k]]).statistic;
            if k < 7 {
                prop_assert!(found.abs() < f64::EPSILON);
                continue;
            }
            let share = |list: &[f64], x: f64| {
                list.iter().filter(|v| **v <= x).count() as f64 / list.len() as f64
            };
            let window = &values[k - 7..=k];
            let distance = (-14..14)
                .map(|half| 0.5 * f64::from(half))
                .map(|x| (share(window, x) - share(&reference, x)).abs())
                .fold(0.0, f64::max);
            prop_assert!(is_near(found, distance * (n * m / (n + m)).sqrt(), 1e-12));
        }
    }
}

#[test]
fn two_sample_thresholds_agree_with_the_published_quantiles() {
    for (alpha, printed) in [(0.05, 1.35810), (0.01, 1.62762), (0.001, 1.94947)] {
        assert!((kolmogorov_constant(alpha) - printed).abs() < 5.1e-6, "{alpha}");
    }
    let t = two_sample::threshold(SampleTest::Mean, 6, 6, 0.05).unwrap();
    assert!((t - 2.228_139).abs() < 1e-6, "Student, 10 degrees, 97.5 %: {t}");
    let f = two_sample::threshold(SampleTest::Variance, 6, 11, 0.1).unwrap();
    assert!((f.exp() - 4.735_06).abs() < 1e-4, "Fisher, (10, 5) degrees, 95 %: {}", f.exp());
    assert!(two_sample::threshold(SampleTest::Mean, 1, 6, 0.05).is_err());
    assert!(two_sample::threshold(SampleTest::Mean, 6, 6, 0.0).is_err());
}

#[test]
fn two_sample_tests_keep_their_rate_on_white_residuals() {
    let healthy = white(20_000, 21);
    let rows = SampleRows::new(1, &healthy).unwrap();
    for test in [SampleTest::Mean, SampleTest::Variance, SampleTest::Distribution] {
        let (window, wanted) = (40, 0.05);
        let threshold = two_sample::threshold(test, window, healthy.len(), wanted).unwrap();
        let mut detector = TwoSample::<f64>::new(test, rows, window, threshold).unwrap();
        let windows = 5000;
        let fresh = white(window * windows, 22);
        let alarms = fresh
            .chunks(window)
            .filter(|values| {
                values.iter().filter(|r| detector.update(&[], &[**r]).alarm()).count() > 0
            })
            .count();
        // Only the verdict at the end of each window is independent of the others.
        let mut ends = 0;
        Stage::<f64>::reset(&mut detector);
        for values in fresh.chunks(window) {
            let mut last = false;
            for r in values {
                last = detector.update(&[], &[*r]).alarm();
            }
            ends += u32::from(last);
        }
        let rate = f64::from(ends) / windows as f64;
        println!("{test:?}: {rate} of the windows, {alarms} with any alarm");
        // Standard error 0.3 %. The limit law is conservative by about 1/√n for windows of 40, and so
        // is the wider of two unequal tails of F.
        assert!(rate < wanted + 0.013 && rate > 0.5 * wanted, "{test:?}: {rate}");
    }
}

#[test]
fn each_two_sample_test_finds_its_change_and_is_deaf_to_the_others() {
    let healthy = white(5000, 31);
    let rows = SampleRows::new(1, &healthy).unwrap();
    let found = |test: SampleTest, change: &dyn Fn(f64) -> f64| {
        let threshold = two_sample::threshold(test, 100, healthy.len(), 1e-4).unwrap();
        let mut detector = TwoSample::<f64>::new(test, rows, 100, threshold).unwrap();
        let fresh = white(100, 32);
        fresh.iter().any(|r| detector.update(&[], &[change(*r)]).alarm())
    };
    let (mean, variance, shape) =
        (SampleTest::Mean, SampleTest::Variance, SampleTest::Distribution);
    let shifted = |r: f64| r + 0.7;
    let noisy = |r: f64| 2.0 * r;
    let dead = |_: f64| 0.0;
    // Same mean and variance, but two-valued.
    let two_valued = |r: f64| r.signum();
    assert!(found(mean, &shifted) && found(shape, &shifted) && !found(variance, &shifted));
    assert!(!found(mean, &noisy) && found(variance, &noisy));
    assert!(!found(mean, &dead) && found(variance, &dead) && found(shape, &dead));
    assert!(
        !found(mean, &two_valued) && !found(variance, &two_valued) && found(shape, &two_valued)
    );
}
