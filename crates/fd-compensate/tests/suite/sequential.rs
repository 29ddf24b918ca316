//! Sequential and windowed tests: exact run lengths, brute-force statistics, rates on coloured residuals.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use fd_compensate::{
    SampleRows,
    calibrate::{CalibrationPlan, FalseAlarms, calibrate},
    detect::{
        Glr, Sprt, Standardizer, TwoSample,
        cusum::average_run_length,
        glr::{Course, GlrDesign},
        sprt::{ErrorProbabilities, Sides, operating_characteristic},
        two_sample::SampleTest,
        whiten::{Whitener, WhitenerDesign},
    },
    evaluate::run_length,
};
use fd_core::{Scalar, stage::Detector};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

fn source(seed: u64) -> impl FnMut() -> f64 {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    move || StandardNormal.sample(&mut random)
}

/// First-order autoregressive noise of unit variance, stationary from the start.
fn coloured(n: usize, pole: f64, seed: u64) -> Vec<f64> {
    let mut draw = source(seed);
    let mut x = draw();
    (0..n)
        .map(|_| {
            let now = x;
            x = pole * x + (1.0 - pole * pole).sqrt() * draw();
            now
        })
        .collect()
}

fn unit() -> Standardizer<f64> {
    Standardizer::new(&[0.0], &[1.0]).unwrap()
}

const ERRORS: ErrorProbabilities = ErrorProbabilities { false_alarm: 0.01, missed: 0.05 };

/// With the lower boundary at zero the restarted test is one side of the cumulative sum with k = δ/2 and
/// h = ln B / δ, so the published run lengths of that hold; two equal sides alarm twice as often.
#[test]
fn the_test_with_its_lower_boundary_at_zero_has_the_run_lengths_of_the_cusum() {
    for (shift, printed) in
        [(0.0, 2.0 * 167.68), (1.0, 8.38), (1.5, 4.75), (2.0, 3.34), (4.0, 1.71)]
    {
        let found = operating_characteristic((-1e-9, 4.0), 1.0, shift).unwrap();
        let upper = found.average_run_length;
        // Printed to two digits; at a shift of 1 and more the lower side does not alarm.
        assert!((upper - printed).abs() < 0.011, "{shift}: {upper} for {printed}");
    }
    let exact = 2.0 * average_run_length(5.5, 0.4, 0.0).unwrap();
    let found = operating_characteristic((-1e-12, 4.4), 0.8, 0.0).unwrap().average_run_length;
    assert!((found / exact - 1.0).abs() < 1e-9, "{found} {exact}");
}

#[test]
fn the_running_test_has_the_computed_run_lengths() {
    let (lower, upper) = ERRORS.boundaries().unwrap();
    let mut detector = Sprt::<f64>::new(unit(), 1.0, ERRORS, Sides::Upper).unwrap();
    for (shift, runs) in [(0.0, 1500), (0.5, 10_000), (1.0, 20_000), (2.0, 20_000)] {
        let exact = operating_characteristic((lower, upper), 1.0, shift).unwrap();
        let mut draw = source(7);
        let found = run_length(&mut detector, runs, 100_000, |_, r| r[0] = shift + draw());
        println!("sprt shift {shift}: {found:?} for {exact:?}");
        assert_eq!(found.cut, 0);
        // Four standard errors: fails once in 16 000 seeds if the code is right.
        let (low, high) = found.interval(4.0);
        assert!((low..high).contains(&exact.average_run_length), "{shift}: {found:?} {exact:?}");
    }
    // Overshoot works for the user: both errors are below those asked for, the test a little longer.
    let healthy = operating_characteristic((lower, upper), 1.0, 0.0).unwrap();
    let faulty = operating_characteristic((lower, upper), 1.0, 1.0).unwrap();
    assert!(healthy.alarm_probability < 0.01 && healthy.alarm_probability > 0.003);
    assert!(faulty.alarm_probability > 0.95 && faulty.alarm_probability < 0.99);
}

#[test]
fn malformed_tests_are_refused() {
    let errors = |false_alarm, missed| ErrorProbabilities { false_alarm, missed }.boundaries();
    assert!(errors(0.0, 0.1).is_err() && errors(0.1, 0.0).is_err() && errors(0.5, 0.5).is_err());
    assert!(operating_characteristic((0.0, 1.0), 1.0, 0.0).is_err());
    assert!(operating_characteristic((-1.0, 100.0), 1.0, 0.0).is_err());
    assert!(Sprt::<f64>::new(unit(), 0.0, ERRORS, Sides::Both).is_err());
    let one = [1.0, 2.0, 3.0];
    let rows = SampleRows::new(1, &one).unwrap();
    assert!(TwoSample::<f64>::new(SampleTest::Mean, rows, 1, 1.0).is_err());
    let flat = [1.0; 5];
    let flat = SampleRows::new(1, &flat).unwrap();
    assert!(TwoSample::<f64>::new(SampleTest::Mean, flat, 2, 1.0).is_err());
    let white = || WhitenerDesign::new(&[0.0], &[vec![]], &[1.0]).unwrap();
    assert!(GlrDesign::any_direction(white(), &[], 5).is_err());
    assert!(GlrDesign::any_direction(white(), &[Course::Step], 0).is_err());
    assert!(GlrDesign::along(white(), &[], &[Course::Step], 5).is_err());
    assert!(GlrDesign::along(white(), &[vec![0.0]], &[Course::Step], 5).is_err());
    assert!(GlrDesign::along(white(), &[vec![1.0, 1.0]], &[Course::Step], 5).is_err());
    assert!(WhitenerDesign::new(&[0.0], &[vec![], vec![]], &[1.0]).is_err());
    assert!(WhitenerDesign::new(&[0.0], &[vec![]], &[-1.0]).is_err());
}

fn white_glr(window: usize, threshold: f64) -> Glr<f64> {
    let white = WhitenerDesign::new(&[0.0], &[vec![]], &[1.0]).unwrap();
    let design = GlrDesign::any_direction(white, &[Course::Step], window).unwrap();
    Glr::new(&design, threshold).unwrap()
}

/// One onset is a Shewhart chart: `z² > 9` once in 370.398 samples, `(z + 1)² > 9` once in 43.895.
#[test]
fn one_onset_has_the_run_length_of_a_shewhart_chart() {
    for (shift, exact) in [(0.0, 370.398), (1.0, 43.895)] {
        let mut draw = source(11);
        let mut detector = white_glr(1, 9.0);
        let found = run_length(&mut detector, 8000, 100_000, |_, r| r[0] = shift + draw());
        println!("glr of one onset, shift {shift}: {found:?} for {exact}");
        let (low, high) = found.interval(4.0);
        assert!((low..high).contains(&exact), "{found:?}");
    }
}

/// At equal run lengths between false alarms, more onsets find small faults earlier than one, and a large
/// fault about as early.
#[test]
fn more_onsets_find_small_faults_earlier() {
    let measure = |window: usize, threshold: f64, shift: f64, runs: usize| {
        let mut draw = source(13);
        let mut detector = white_glr(window, threshold);
        run_length(&mut detector, runs, 200_000, |_, r| r[0] = shift + draw())
    };
    // Exact for one onset: N(shift, 1) beyond three.
    let one = [370.398, 155.224, 43.895, 6.303, 2.0];
    for (window, threshold) in [(20, 11.5), (50, 11.8)] {
        let shifts = [0.0, 0.5, 1.0, 2.0, 3.0];
        let found = shifts.map(|shift| measure(window, threshold, shift, 1000));
        println!("glr window {window}, threshold {threshold}, shifts {shifts:?}: {found:?}");
        // Three standard errors of a thousand runs are a tenth.
        assert!(found[0].mean > 0.9 * one[0], "{found:?}");
        assert!(found[1].mean < 0.4 * one[1] && found[2].mean < 0.4 * one[2], "{found:?}");
        assert!(found[4].mean < 1.1 * one[4], "{found:?}");
    }
}

fn is_near(a: f64, b: f64, relative: f64) -> bool {
    (a - b).abs() <= relative * (1.0 + a.abs().max(b.abs()))
}

/// Least squares over every onset, written out: the log-likelihood ratio is the drop of the squared error.
fn brute_force(white: &[Vec<f64>], effects: &[Vec<f64>], k: usize) -> f64 {
    let window = effects.len().min(k + 1);
    (1..=window)
        .map(|age| {
            let (mut c, mut j) = (0.0, 0.0);
            for i in 0..age {
                for (e, f) in white[k + 1 - age + i].iter().zip(&effects[i]) {
                    c += e * f;
                    j += f * f;
                }
            }
            c * c / j
        })
        .fold(0.0, f64::max)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn the_recursion_is_the_brute_force_likelihood_ratio(
        seed in 0_u64..1000, window in 1_usize..12, a in -0.8..0.8_f64, b in -0.8..0.8_f64,
        g in prop::array::uniform2(-2.0..2.0_f64),
    ) {
        prop_assume!(g[0].abs() > 0.1);
        let design =
            WhitenerDesign::new(&[0.5, -1.0], &[vec![a, 0.1], vec![b, 0.0]], &[2.0, 0.6, 0.6, 1.0])
                .unwrap();
        let mut draw = source(seed);
        let rows: Vec<[f64; 2]> = (0..40).map(|_| [draw(), draw()]).collect();
        let mut whitener = Whitener::<f64>::new(&design);
        let white: Vec<Vec<f64>> = rows.iter().map(|r| whitener.update(r).to_vec()).collect();
        for (course, profile) in [
            (Course::Step, vec![1.0; window]),
            (Course::Ramp, (1..=window).map(|t| t as f64).collect()),
        ] {
            let effects = design.response(&g, &profile).unwrap();
            let along = GlrDesign::along(design.clone(), &[g.to_vec()], &[course], window).unwrap();
            let mut detector = Glr::<f64>::new(&along, 1.0).unwrap();
            for (k, r) in rows.iter().enumerate() {
                let found = detector.update(&[], r).statistic;
                // A few dozen roundings.
                prop_assert!(is_near(found, brute_force(&white, &effects, k), 1e-11));
            }
        }
    }

    /// The likelihood ratio in any direction is at least that along each signature, and at most their sum
    /// when these are orthogonal directions of white noise.
    #[test]
    fn any_direction_covers_every_signature(seed in 0_u64..1000) {
        let design = WhitenerDesign::new(&[0.0; 2], &[vec![], vec![]], &[1.0, 0.0, 0.0, 1.0]).unwrap();
        let courses = [Course::Step];
        let any = GlrDesign::any_direction(design.clone(), &courses, 6).unwrap();
        let axes = vec![vec![1.0, 0.0], vec![0.0, 1.0]];
        let along = GlrDesign::along(design, &axes, &courses, 6).unwrap();
        let (mut any, mut along) =
            (Glr::<f64>::new(&any, 1.0).unwrap(), Glr::<f64>::new(&along, 1.0).unwrap());
        let mut draw = source(seed);
        for _ in 0..30 {
            let r = [draw(), draw()];
            let (a, b) = (any.update(&[], &r).statistic, along.update(&[], &r).statistic);
            prop_assert!(b <= a * (1.0 + 1e-12) && a <= 2.0 * b * (1.0 + 1e-12));
        }
    }
}

/// A coloured residual with a step along the second of three signatures.
#[test]
fn onset_signature_and_size_are_found() {
    let n = 20_000;
    let (a, b) = (coloured(n, 0.7, 1), coloured(n, 0.3, 2));
    let healthy: Vec<f64> = a.iter().zip(&b).flat_map(|(a, b)| [*a, 0.5 * a + b]).collect();
    let rows = SampleRows::new(2, &healthy).unwrap();
    let whitener = WhitenerDesign::from_fault_free(rows, 6).unwrap();
    let signatures = [vec![1.0, 0.0], vec![0.5, 1.0], vec![-1.0, 1.0]];
    let design =
        GlrDesign::along(whitener, &signatures, &[Course::Step, Course::Ramp], 60).unwrap();
    let mut detector = Glr::<f64>::new(&design, 40.0).unwrap();
    let (a, b) = (coloured(200, 0.7, 3), coloured(200, 0.3, 4));
    let mut last = None;
    for k in 0..200 {
        let fault = if k >= 150 { 3.0 } else { 0.0 };
        let r = [a[k] + 0.5 * fault, 0.5 * a[k] + b[k] + fault];
        if detector.update(&[], &r).alarm() {
            last = Some((k, detector.change().unwrap(), detector.size().to_vec()));
        }
    }
    let (k, change, size) = last.unwrap();
    println!("at {k}: {change:?} {size:?}");
    assert_eq!((k, change.course, change.signature), (199, Course::Step, Some(1)));
    assert!((48..=52).contains(&change.age), "{change:?}");
    // Standard error of the size over 50 samples of this colour: about 0.2.
    assert!(size.len() == 1 && (size[0] - 3.0).abs() < 0.8, "{size:?}");
}

#[test]
fn whitening_whitens() {
    let n = 50_000;
    let (a, b) = (coloured(n, 0.9, 5), coloured(n, -0.5, 6));
    let values: Vec<f64> = a.iter().zip(&b).flat_map(|(a, b)| [3.0 + a, 1e3 * (a + b)]).collect();
    let rows = SampleRows::new(2, &values).unwrap();
    let design = WhitenerDesign::from_fault_free(rows, 10).unwrap();
    let mut whitener = Whitener::<f64>::new(&design);
    let white: Vec<Vec<f64>> = rows.iter().map(|r| whitener.update(r).to_vec()).collect();
    let mean_of = |lag: usize, i: usize, j: usize| {
        let pairs = white.iter().zip(&white[lag..]);
        pairs.map(|(a, b)| a[i] * b[j]).sum::<f64>() / n as f64
    };
    for (i, j) in [(0, 0), (0, 1), (1, 1)] {
        let expected = f64::from(u8::from(i == j));
        // Sampling error of a covariance: 1/√n, four of them.
        assert!((mean_of(0, i, j) - expected).abs() < 0.02, "{i} {j}: {}", mean_of(0, i, j));
    }
    for lag in [1, 2, 5] {
        assert!(mean_of(lag, 0, 0).abs() < 0.02, "{lag}: {}", mean_of(lag, 0, 0));
    }
}

/// Every test of this page, calibrated on a coloured residual, keeps the stated rate on fresh ones.
#[test]
fn calibrated_rates_are_kept_on_coloured_residuals() {
    let (n, pole, wanted) = (60_000, 0.8, 0.02);
    let plan = CalibrationPlan { records: 1, ..CalibrationPlan::default() };
    let build = |rows: SampleRows<'_>| -> Vec<(&str, Box<dyn Detector<f64>>)> {
        let whitener = WhitenerDesign::from_fault_free(rows, 5).unwrap();
        let glr = GlrDesign::any_direction(whitener, &[Course::Step], 20).unwrap();
        let two = |test| Box::new(TwoSample::new(test, rows, 30, 1.0).unwrap());
        vec![
            ("glr", Box::new(Glr::new(&glr, 1.0).unwrap())),
            ("sprt", Box::new(Sprt::new(unit(), 1.0, ERRORS, Sides::Both).unwrap())),
            ("mean", two(SampleTest::Mean)),
            ("variance", two(SampleTest::Variance)),
            ("distribution", two(SampleTest::Distribution)),
        ]
    };
    let mut rates = vec![Vec::new(); 5];
    for record in 0..4 {
        let healthy = coloured(n, pole, 400 + record);
        let rows = SampleRows::new(1, &healthy).unwrap();
        let fresh = coloured(3 * n, pole, 500 + record);
        for ((name, mut detector), rates) in build(rows).into_iter().zip(&mut rates) {
            let question = FalseAlarms::PerSample { rate: wanted };
            let found = calibrate(&mut detector, rows, question, &plan).unwrap();
            detector.reset();
            let above =
                fresh.iter().filter(|r| detector.update(&[], &[**r]).statistic > found.threshold);
            let rate = above.count() as f64 / fresh.len() as f64;
            println!("{name}: threshold {:.3}, rate {rate:.4}", found.threshold);
            rates.push(rate);
        }
    }
    for rates in rates {
        // Statistics remember up to some 90 samples: 600 independent looks in a record, 12 of them above a
        // threshold of 2 %: the rate of one record is good for a factor of three, the mean for two.
        let mean = rates.iter().sum::<f64>() / rates.len() as f64;
        assert!(rates.iter().all(|r| (r / wanted).ln().abs() < 3.0_f64.ln()), "{rates:?}");
        assert!((mean / wanted).ln().abs() < 2.0_f64.ln(), "{mean}");
    }
}

#[test]
fn single_precision_decides_alike() {
    let values = coloured(3000, 0.5, 8);
    let rows = SampleRows::new(1, &values).unwrap();
    let whitener = WhitenerDesign::from_fault_free(rows, 3).unwrap();
    let glr = GlrDesign::any_direction(whitener, &[Course::Step, Course::Ramp], 20).unwrap();
    let z = Standardizer::from_fault_free(rows, fd_compensate::detect::Spread::StandardDeviation);
    let z32 = Standardizer::from_fault_free(rows, fd_compensate::detect::Spread::StandardDeviation);
    let mut doubles: Vec<Box<dyn Detector<f64>>> = vec![
        Box::new(Glr::new(&glr, 8.0).unwrap()),
        Box::new(Sprt::new(z.unwrap(), 1.0, ERRORS, Sides::Both).unwrap()),
        Box::new(TwoSample::new(SampleTest::Mean, rows, 30, 2.0).unwrap()),
        Box::new(TwoSample::new(SampleTest::Variance, rows, 30, 0.5).unwrap()),
        Box::new(TwoSample::new(SampleTest::Distribution, rows, 30, 1.5).unwrap()),
    ];
    let mut singles: Vec<Box<dyn Detector<f32>>> = vec![
        Box::new(Glr::new(&glr, 8.0).unwrap()),
        Box::new(Sprt::new(z32.unwrap(), 1.0, ERRORS, Sides::Both).unwrap()),
        Box::new(TwoSample::new(SampleTest::Mean, rows, 30, 2.0).unwrap()),
        Box::new(TwoSample::new(SampleTest::Variance, rows, 30, 0.5).unwrap()),
        Box::new(TwoSample::new(SampleTest::Distribution, rows, 30, 1.5).unwrap()),
    ];
    let mut alarms = 0;
    for r in &values {
        for (double, single) in doubles.iter_mut().zip(&mut singles) {
            let double = double.update(&[], &[*r]);
            let single = single.update(&[], &[f32::from_design(*r)]);
            // Windows of 30 samples keep some hundred roundings of 6e-8.
            let clear = (double.statistic - double.threshold).abs() > 1e-3 * double.threshold;
            assert!(!clear || double.alarm() == single.alarm());
            alarms += u32::from(single.alarm());
        }
    }
    assert!(alarms > 10, "{alarms}");
}
