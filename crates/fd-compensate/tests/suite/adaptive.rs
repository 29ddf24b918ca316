//! Thresholds that follow the input: what they bound, what they promise, what they are worth.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use faer::mat;
use fd_compensate::{
    DrivenRows, SampleRows,
    calibrate::{CalibrationError, CalibrationPlan, FalseAlarms, calibrate},
    decide::Debouncing,
    detect::{
        AdaptiveThreshold, DetectorError, NSigma, Spread, Standardizer,
        adaptive::{Bands, Evaluation, InputBound, LearnedBound, noise_levels},
    },
    evaluate::smallest_detectable_by_search,
};
use fd_core::{
    Heap, Scalar, Snapshot,
    stage::{Detector, Plant, Stage},
};
use fd_model::{
    Discrete, SampleTime, StateSpace,
    uncertainty::{MatrixPerturbation, Uncertainty},
};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

fn normals(n: usize, seed: u64) -> Vec<f64> {
    let random = Xoshiro256PlusPlus::seed_from_u64(seed);
    StandardNormal.sample_iter(random).take(n).collect()
}

/// Transfers `H_y ΔG` of models with 2 % perturbation, `H_y = 1`: two inputs, two outputs, a light mode.
fn ensemble(models: u64) -> Vec<StateSpace<Discrete>> {
    let ts = SampleTime::new(0.1).unwrap();
    let nominal = StateSpace::new(
        mat![[0.95, 0.1, 0.0], [-0.1, 0.95, 0.1], [0.0, 0.0, 0.7]],
        mat![[0.1, 0.0], [0.0, 0.1], [0.3, 0.1]],
        mat![[1.0, 0.0, 0.0], [0.0, 1.0, 1.0]],
        mat![[0.0, 0.0], [0.0, 0.0]],
        Discrete { ts },
    )
    .unwrap();
    let two_percent = MatrixPerturbation { fraction: 0.02, ..MatrixPerturbation::default() };
    let unit = StateSpace::gain(faer::Mat::identity(2, 2), Discrete { ts }).unwrap();
    (0..models)
        .map(|seed| {
            let plant = two_percent.draw(&nominal, seed).unwrap().model;
            let uncertainty = Uncertainty::between(&nominal, &plant).unwrap();
            uncertainty.residual_transfer(&unit, &nominal).unwrap()
        })
        .collect()
}

fn response(system: &StateSpace<Discrete>, u: &[f64]) -> Vec<f64> {
    let plant = system.freeze::<f64, Heap>().unwrap();
    let (mut x, mut next, mut y) =
        (vec![0.0; system.nx()], vec![0.0; system.nx()], vec![0.0; system.ny()]);
    u.chunks_exact(system.nu())
        .flat_map(|u| {
            plant.output(&x, u, &mut y);
            plant.advance(&x, u, &mut next);
            std::mem::swap(&mut x, &mut next);
            y.clone()
        })
        .collect()
}

#[test]
fn the_ensemble_is_bounded_at_every_frequency_and_not_by_far() {
    let transfers = ensemble(20);
    let bands = Bands::spaced(100.0, 5, 200.0).unwrap();
    let bound = InputBound::over_ensemble(&transfers, bands, &[1.0, 1.0]).unwrap();
    let mut excess: Vec<f64> = Vec::new();
    let peak = |i, j| {
        let gains = transfers.iter().map(|g| g.frequency_response(1.0).unwrap()[(i, j)].norm());
        gains.fold(0.0, f64::max)
    };
    // Frequencies that are not those of the design.
    for k in 0..400 {
        let omega = 1e-3 * (3.1e3_f64).powf(f64::from(k) / 400.0);
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let largest = transfers
                .iter()
                .map(|g| g.frequency_response(omega / 0.1).unwrap()[(i, j)].norm())
                .fold(0.0, f64::max);
            let bounded = bound.gain(i, j, omega);
            // Between two points of the grid, 7 % apart, a light mode may stick out a little.
            assert!(bounded > 0.98 * largest, "({i},{j}) at {omega}: {bounded} for {largest}");
            // The design does not resolve gains below a twentieth of the largest one.
            if largest > 0.1 * peak(i, j) {
                excess.push(bounded / largest);
            }
        }
    }
    excess.sort_by(f64::total_cmp);
    let (median, worst) = (excess[excess.len() / 2], excess[excess.len() - 1]);
    println!("bound over largest gain: median {median}, worst {worst}");
    // First-order bands over a resonance: wide, but of the right order.
    assert!(median < 5.0, "{median}");
}

/// The norm of the bias stays below the bound for every model and two kinds of input.
#[test]
fn the_bias_of_every_model_stays_below_the_bound() {
    let transfers = ensemble(20);
    let bands = Bands::spaced(100.0, 5, 1000.0).unwrap();
    // Hardly any noise: the bound is that of the uncertainty.
    let bound = InputBound::over_ensemble(&transfers, bands, &[1e-9, 1e-9]).unwrap();
    let slow: Vec<f64> = (0..8000).map(|k| (f64::from(k / 2) * 0.01).sin()).collect();
    let mut closest = 0.0_f64;
    for u in [normals(8000, 5), slow] {
        for transfer in &transfers {
            let r = response(transfer, &u);
            let mut detector = AdaptiveThreshold::<f64>::of_rms(&bound, 1.0).unwrap();
            for (k, (u, r)) in u.chunks_exact(2).zip(r.chunks_exact(2)).enumerate() {
                let verdict = detector.update(u, r);
                // The window of the residual fills within a few memories.
                assert!(!verdict.alarm(), "sample {k}: {}", verdict.statistic);
                closest = closest.max(verdict.statistic);
            }
        }
    }
    println!("largest norm of a bias over its bound: {closest}");
    assert!(closest > 0.1, "a bound that nothing comes near is none: {closest}");
}

/// A plant whose model is wrong, driven by an input that is quiet and loud in turn.
fn healthy(n: usize, seed: u64) -> (Vec<f64>, Vec<f64>) {
    let (drive, noise) = (normals(n, seed), normals(n, seed + 1000));
    let (mut u, mut bias, mut colour) = (0.0, 0.0, 0.0);
    (0..n)
        .map(|k| {
            let loud = if (k / 400) % 2 == 0 { 1.0 } else { 0.05 };
            u += 0.1 * (loud * drive[k] * 4.0 - u);
            bias += 0.2 * (0.5 * u - bias);
            colour = 0.7 * colour + 0.05 * noise[k];
            (u, bias + colour)
        })
        .unzip()
}

#[test]
fn a_learned_bound_covers_its_quantile_on_fresh_logs() {
    let bands = Bands::spaced(50.0, 3, 20.0).unwrap();
    for evaluation in [Evaluation::Magnitude, Evaluation::RootMeanSquare] {
        let (u, r) = healthy(8000, 1);
        let rows =
            DrivenRows::new(SampleRows::new(1, &u).unwrap(), SampleRows::new(1, &r).unwrap())
                .unwrap();
        let learned = LearnedBound { quantile: 0.9, evaluation };
        let bound = InputBound::from_fault_free(rows, bands.clone(), &learned).unwrap();
        let mut detector = AdaptiveThreshold::new(&bound, evaluation, 1.0).unwrap();
        let (u, r) = healthy(40_000, 2);
        let above = u.iter().zip(&r).filter(|(u, r)| detector.update(&[**u], &[**r]).alarm());
        let share = above.count() as f64 / 40_000.0;
        println!("{evaluation:?}: {share} above the bound of the 90 % quantile");
        // About 8000 / 40 independent looks: standard error 2 %, four of them.
        assert!((share - 0.1).abs() < 0.08, "{evaluation:?}: {share}");
    }
}

#[test]
fn a_calibrated_adaptive_threshold_keeps_its_rate_on_fresh_logs() {
    let wanted = 0.02;
    for evaluation in [Evaluation::Magnitude, Evaluation::RootMeanSquare] {
        let mut rates = Vec::new();
        for seed in 0..4 {
            let (u, r) = healthy(20_000, 10 + seed);
            let rows =
                DrivenRows::new(SampleRows::new(1, &u).unwrap(), SampleRows::new(1, &r).unwrap())
                    .unwrap();
            let learned = LearnedBound { evaluation, ..LearnedBound::default() };
            let bands = Bands::spaced(50.0, 3, 20.0).unwrap();
            let bound = InputBound::from_fault_free(rows, bands, &learned).unwrap();
            let mut detector = AdaptiveThreshold::<f64>::new(&bound, evaluation, 1.0).unwrap();
            let plan = CalibrationPlan { records: 2, ..CalibrationPlan::default() };
            let question = FalseAlarms::PerSample { rate: wanted };
            let found = calibrate(&mut detector, rows, question, &plan).unwrap();
            let mut detector = detector.with_threshold(found.threshold).unwrap();
            let (u, r) = healthy(60_000, 50 + seed);
            let alarms = u.iter().zip(&r).filter(|(u, r)| detector.update(&[**u], &[**r]).alarm());
            rates.push(alarms.count() as f64 / 60_000.0);
        }
        println!("{evaluation:?}: {rates:?} for {wanted}");
        // Windows of 20 samples: 20 000 samples hold some 500 independent looks, the rate of 2 %
        // about 10 exceedances of them; a threshold from them is good for a factor of three.
        assert!(rates.iter().all(|r| (r / wanted).ln().abs() < 3.0_f64.ln()), "{rates:?}");
    }
}

/// What an adaptive threshold is for: at the same rate of false alarms, a fault in a quiet stretch is
/// found at a fraction of the size that a constant threshold needs.
#[test]
fn a_fault_in_a_quiet_stretch_is_found_earlier_than_with_a_constant_threshold() {
    let (u, r) = healthy(200_000, 3);
    let residual = SampleRows::new(1, &r).unwrap();
    let rows = DrivenRows::new(SampleRows::new(1, &u).unwrap(), residual).unwrap();
    let rule = Debouncing::consecutive(5);
    let plan = CalibrationPlan { records: 1, debouncing: rule, ..CalibrationPlan::default() };
    let wanted = FalseAlarms::PerSample { rate: 2e-3 };

    let standard = Standardizer::from_fault_free(residual, Spread::StandardDeviation).unwrap();
    let mut constant = NSigma::<f64>::new(standard, 1.0).unwrap();
    let found = calibrate(&mut constant, rows, wanted, &plan).unwrap();
    let mut constant = constant.with_threshold(found.threshold).unwrap();

    let bands = Bands::spaced(50.0, 3, 20.0).unwrap();
    let bound = InputBound::from_fault_free(rows, bands, &LearnedBound::default()).unwrap();
    let mut adaptive = AdaptiveThreshold::<f64>::of_magnitude(&bound, 1.0).unwrap();
    let found = calibrate(&mut adaptive, rows, wanted, &plan).unwrap();
    let mut adaptive = adaptive.with_threshold(found.threshold).unwrap();

    // Quiet stretches of a fresh log, their second half with a lasting fault.
    let (u, r) = healthy(16_000, 4);
    let step: Vec<f64> = (0..400).map(|k| f64::from(u8::from(k >= 200))).collect();
    let step = SampleRows::new(1, &step).unwrap();
    let smallest = |detector: &mut dyn Detector<f64>| {
        let mut sizes: Vec<f64> = (0..20)
            .map(|stretch| {
                let quiet = 800 * stretch + 400..800 * stretch + 800;
                let u = SampleRows::new(1, &u[quiet.clone()]).unwrap();
                let rows = DrivenRows::new(u, SampleRows::new(1, &r[quiet]).unwrap()).unwrap();
                smallest_detectable_by_search(detector, rule, rows, step, 10.0).unwrap().unwrap()
            })
            .collect();
        sizes.sort_by(f64::total_cmp);
        sizes[sizes.len() / 2]
    };
    let (constant, adaptive) = (smallest(&mut constant), smallest(&mut adaptive));
    println!("median smallest fault: {constant} constant threshold, {adaptive} adaptive");
    assert!(adaptive > 0.0 && adaptive < 0.5 * constant, "{adaptive} {constant}");
}

/// Of n samples there are n − 1 differences, each of twice the variance of white noise.
#[test]
fn the_noise_level_is_the_mean_over_differences() {
    let samples = [1.0, 10.0, 3.0, 10.0, 1.0, 16.0];
    let levels = noise_levels(SampleRows::new(2, &samples).unwrap()).unwrap();
    let expected = [(0.5 * (4.0 + 4.0) / 2.0_f64).sqrt(), (0.5 * 36.0 / 2.0_f64).sqrt()];
    // Rounding of a root.
    assert!(levels.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{levels:?}");
}

#[test]
fn what_a_bound_cannot_be_made_of_is_refused() {
    let bands = || Bands::new(&[0.1], 10.0).unwrap();
    assert!(Bands::new(&[0.2, 0.1], 10.0).is_err());
    assert!(Bands::new(&[0.1], 0.5).is_err());
    assert!(Bands::spaced(1.0, 3, 10.0).is_err());
    assert!(InputBound::new(bands(), 1, &[0.0], &[1.0, 1.0]).is_err());
    assert!(InputBound::new(bands(), 1, &[1.0], &[1.0, -1.0]).is_err());
    let error = InputBound::new(bands(), 1, &[1.0], &[1.0]).unwrap_err();
    assert_eq!(error, DetectorError::Length { parameter: "gains", expected: 2, found: 1 });
    assert!(InputBound::over_ensemble(&[], bands(), &[1.0]).is_err());
    let r = [1.0, 2.0, 1.0];
    let rows = SampleRows::new(1, &r).unwrap();
    let without = InputBound::from_fault_free(rows.into(), bands(), &LearnedBound::default());
    assert!(without.is_err());
    assert!(noise_levels(SampleRows::new(1, &[1.0, 1.0]).unwrap()).is_err());
    // A record without inputs is not what an adaptive threshold is calibrated on.
    let bound = InputBound::new(bands(), 1, &[1.0], &[1.0, 1.0]).unwrap();
    let mut detector = AdaptiveThreshold::<f64>::of_magnitude(&bound, 1.0).unwrap();
    let wanted = FalseAlarms::PerSample { rate: 0.1 };
    let error = calibrate(&mut detector, rows, wanted, &CalibrationPlan::default()).unwrap_err();
    assert_eq!(error, CalibrationError::Inputs { expected: 1, found: 0 });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// The bands of any input add up to it: with equal weights a constant passes unchanged, and every
    /// frequency is covered.
    #[test]
    fn bands_cover_every_frequency(
        slowest in 2.0..1e4_f64, corners in 1_usize..8, omega in 0.0..std::f64::consts::PI,
    ) {
        let gains = Bands::spaced(slowest, corners, 10.0).unwrap().gains(omega);
        prop_assert_eq!(gains.len(), corners + 1);
        prop_assert!(gains.iter().sum::<f64>() >= 1.0 - 1e-12);
        let at_rest = Bands::spaced(slowest, corners, 10.0).unwrap().gains(0.0);
        prop_assert!((at_rest[0] - 1.0).abs() < 1e-12 && at_rest[1..].iter().all(|g| g.abs() < 1e-12));
    }

    /// Larger inputs never narrow the bound, and input and noise scaled together scale it.
    #[test]
    fn the_bound_grows_with_the_input(
        u in prop::collection::vec(-1.0..1.0_f64, 30), factor in 1.0..9.0_f64,
    ) {
        let build = |noise: f64| {
            let bands = Bands::new(&[0.05, 0.4], 10.0).unwrap();
            let bound = InputBound::new(bands, 1, &[noise], &[0.3, 0.2, 0.1]).unwrap();
            AdaptiveThreshold::<f64>::of_magnitude(&bound, 2.0).unwrap()
        };
        let (mut plain, mut louder, mut scaled) = (build(0.1), build(0.1), build(0.1 * factor));
        for u in u {
            plain.update(&[u], &[0.0]);
            louder.update(&[factor * u], &[0.0]);
            scaled.update(&[factor * u], &[0.0]);
            let at = |d: &AdaptiveThreshold<f64>| d.thresholds().next().unwrap();
            prop_assert!(at(&louder) >= at(&plain) * (1.0 - 1e-12));
            prop_assert!((at(&scaled) / at(&plain) / factor - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn reset_and_restore_give_the_same_future(
        samples in prop::collection::vec((-1.0..1.0_f64, -1.0..1.0_f64), 60), cut in 0_usize..60,
    ) {
        for evaluation in [Evaluation::Magnitude, Evaluation::RootMeanSquare] {
            let bands = Bands::new(&[0.05, 0.4], 10.0).unwrap();
            let bound = InputBound::new(bands, 1, &[0.2], &[0.3, 0.2, 0.1]).unwrap();
            let build = || AdaptiveThreshold::<f64>::new(&bound, evaluation, 1.0).unwrap();
            let run = |d: &mut AdaptiveThreshold<f64>, part: &[(f64, f64)]| -> Vec<u64> {
                part.iter().map(|(u, r)| d.update(&[*u], &[*r]).statistic.to_bits()).collect()
            };
            let (mut one, mut two) = (build(), build());
            let first = run(&mut one, &samples[..cut]);
            let snapshot = Snapshot::of(&mut one);
            let second = run(&mut one, &samples[cut..]);
            snapshot.restore(&mut two).unwrap();
            prop_assert_eq!(&second, &run(&mut two, &samples[cut..]));
            one.reset();
            prop_assert_eq!(&first, &run(&mut one, &samples[..cut]));
            // Single precision: a hundred roundings of 6e-8.
            let mut single = AdaptiveThreshold::<f32>::new(&bound, evaluation, 1.0).unwrap();
            let mut double = build();
            for (u, r) in &samples {
                let (s, d) = (
                    single.update(&[f32::from_design(*u)], &[f32::from_design(*r)]),
                    double.update(&[*u], &[*r]),
                );
                prop_assert!((s.statistic.to_report() - d.statistic).abs() < 1e-4 * (1.0 + d.statistic));
            }
        }
    }
}
