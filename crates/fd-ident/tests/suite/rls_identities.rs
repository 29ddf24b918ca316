//! Recursive least squares equals the batch problems that it stands for (case I2).
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use crate::common::noise;
use faer::Mat;
use fd_core::{Heap, Snapshot, testing::nonsense};
use fd_ident::{
    least_squares::LeastSquares,
    rls::{
        Conventional, Covariance, Falling, Forgetting, Guard, QrRls, Rls, RlsDesign, RlsKernel,
        RlsStorage, Static, Ud, WindowDesign, WindowRls,
    },
};
use proptest::prelude::*;

const N: usize = 4;

/// Regressors with uniform entries, hence persistently exciting, and noisy targets.
fn data(seed: u64, rows: usize) -> Vec<([f64; N], f64)> {
    let numbers = noise(seed, rows * (N + 1));
    let row = |r: &[f64]| {
        let phi = [r[0], r[1], r[2], r[3]];
        (phi, 2.0 * r[0] - r[1] + 0.5 * r[2] + 0.1 * r[4])
    };
    numbers.chunks_exact(N + 1).map(row).collect()
}

fn run<K: RlsKernel<f64>>(mut kernel: K, data: &[([f64; N], f64)]) -> ([f64; N], [f64; N], K) {
    let (mut theta, mut variance) = ([0.0; N], [0.0; N]);
    for (phi, y) in data {
        kernel.update(phi, *y, &mut theta);
    }
    kernel.variance_into(&mut variance);
    (theta, variance, kernel)
}

fn rls<C: Covariance<f64>>(design: &RlsDesign) -> Rls<f64, C> {
    Rls::new(N, design).unwrap()
}

type UdHeap = Ud<f64, Heap>;
type PlainHeap = Conventional<f64, Heap>;

/// `argmin Σ w_k (y_k − φ_kᵀθ)² + ridge ‖θ‖²` by QR, and the diagonal of the inverse.
fn batch(
    data: &[([f64; N], f64)],
    weight: impl Fn(usize) -> f64,
    ridge: f64,
) -> ([f64; N], [f64; N]) {
    let rows = data.len();
    let x = Mat::from_fn(rows + N, N, |i, j| {
        if i < rows {
            weight(i).sqrt() * data[i].0[j]
        } else {
            ridge.sqrt() * f64::from(u8::from(i - rows == j))
        }
    });
    let mut y: Vec<f64> = (0..rows).map(|i| weight(i).sqrt() * data[i].1).collect();
    y.extend([0.0; N]);
    let fit = LeastSquares::new().solve(x.as_ref(), &y).unwrap();
    let variance = std::array::from_fn(|i| fit.inverse_gram[(i, i)]);
    (fit.coefficients.try_into().unwrap(), variance)
}

fn close(found: &[f64; N], expected: &[f64; N], tolerance: f64) -> Result<(), TestCaseError> {
    let size = expected.iter().fold(0.0_f64, |size, v| size.max(v.abs()));
    for (found, expected) in found.iter().zip(expected) {
        prop_assert!((found - expected).abs() <= tolerance * size, "{} {}", found, expected);
    }
    Ok(())
}

fn any_forgetting() -> impl Strategy<Value = Forgetting> {
    prop_oneof![
        Just(Forgetting::None),
        (0.1..10.0).prop_map(|alpha| Forgetting::Equation18 { alpha, falling: None }),
        (0.1..10.0, 0.9..1.0).prop_map(|(alpha, ratio)| {
            let falling = Some(Falling { ratio, least: 0.01 * alpha });
            Forgetting::Equation18 { alpha, falling }
        }),
        (0.9..1.0).prop_map(|lambda| Forgetting::Exponential { lambda }),
        (0.9..1.0).prop_map(|lambda| Forgetting::Directional { lambda }),
        (0.9..1.0, 1.0..100.0)
            .prop_map(|(lambda, variance)| Forgetting::Bounded { lambda, variance }),
        (0.9..1.0, 0.001..0.5).prop_map(|(lambda, floor)| Forgetting::Resetting { lambda, floor }),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, failure_persistence: None, ..Default::default() })]

    // The tolerance of 1e-9 is eps times the largest condition of the information matrix on the
    // way, about 1e3 prior variance, times a few hundred steps.

    #[test]
    fn without_forgetting_it_is_ridge_least_squares(
        seed: u64, rows in 20_usize..200, prior_variance in 1.0..1e4,
    ) {
        let data = data(seed, rows);
        let (theta, variance) = batch(&data, |_| 1.0, 1.0 / prior_variance);
        let design = RlsDesign { prior_variance, ..RlsDesign::default() };
        let ud = run(rls::<UdHeap>(&design), &data);
        close(&ud.0, &theta, 1e-9)?;
        close(&ud.1, &variance, 1e-9)?;
        let plain = run(rls::<PlainHeap>(&design), &data);
        close(&plain.0, &theta, 1e-9)?;
        close(&plain.1, &variance, 1e-9)?;
    }

    #[test]
    fn exponential_forgetting_is_weighted_least_squares(
        seed: u64, rows in 20_usize..200, prior_variance in 1.0..1e4, lambda in 0.9..1.0_f64,
    ) {
        let data = data(seed, rows);
        let age = |k: usize| i32::try_from(rows - 1 - k).unwrap();
        let ridge = lambda.powi(i32::try_from(rows).unwrap()) / prior_variance;
        let (theta, variance) = batch(&data, |k| lambda.powi(age(k)), ridge);
        let forgetting = Forgetting::Exponential { lambda };
        let design = RlsDesign { prior_variance, forgetting, guard: Guard::off() };
        let ud = run(rls::<UdHeap>(&design), &data);
        close(&ud.0, &theta, 1e-9)?;
        close(&ud.1, &variance, 1e-9)?;
        let plain = run(rls::<PlainHeap>(&design), &data);
        close(&plain.0, &theta, 1e-9)?;
        // The guards that are on by default do not act on exciting data.
        let guarded = run(rls::<UdHeap>(&RlsDesign { guard: Guard::default(), ..design }), &data);
        prop_assert_eq!(guarded.0.map(f64::to_bits), ud.0.map(f64::to_bits));
        prop_assert!(!guarded.2.guard().acted());
    }

    #[test]
    fn equation_18_is_ordinary_least_squares_with_another_prior(
        seed: u64, alpha in 0.1..10.0,
    ) {
        let data = data(seed, 60);
        let design = |prior_variance, forgetting| {
            RlsDesign { prior_variance, forgetting, guard: Guard::default() }
        };
        let paper = run(rls::<UdHeap>(&design(100.0, Forgetting::Equation18 { alpha, falling: None })), &data);
        let plain = run(rls::<UdHeap>(&design(100.0 / alpha, Forgetting::None)), &data);
        close(&paper.0, &plain.0, 1e-11)?;
        // P of the paper is α times larger.
        close(&paper.1, &plain.1.map(|p| alpha * p), 1e-11)?;
    }

    #[test]
    fn factorised_and_conventional_agree_for_every_forgetting(
        seed: u64, forgetting in any_forgetting(),
    ) {
        let data = data(seed, 150);
        let design = RlsDesign { prior_variance: 100.0, forgetting, guard: Guard::default() };
        let ud = run(rls::<UdHeap>(&design), &data);
        let plain = run(rls::<PlainHeap>(&design), &data);
        close(&ud.0, &plain.0, 1e-9)?;
        close(&ud.1, &plain.1, 1e-9)?;
        prop_assert_eq!(ud.2.guard(), plain.2.guard());
        // The triangular factor of the information, for the kinds that it knows.
        if let Ok(kernel) = QrRls::<f64>::new(N, &design) {
            let qr = run(kernel, &data);
            close(&ud.0, &qr.0, 1e-9)?;
            close(&ud.1, &qr.1, 1e-9)?;
        }
    }

    #[test]
    fn static_and_dynamic_sizes_agree_to_the_bit(seed: u64, forgetting in any_forgetting()) {
        let data = data(seed, 100);
        let design = RlsDesign { prior_variance: 100.0, forgetting, guard: Guard::default() };
        let bits = |(theta, variance): ([f64; N], [f64; N])| (theta.map(f64::to_bits), variance.map(f64::to_bits));
        let (theta, variance, _) = run(rls::<Ud<f64, Static<N>>>(&design), &data);
        let dynamic = run(rls::<UdHeap>(&design), &data);
        prop_assert_eq!(bits((theta, variance)), bits((dynamic.0, dynamic.1)));
        let (theta, variance, _) = run(rls::<Conventional<f64, Static<N>>>(&design), &data);
        let dynamic = run(rls::<PlainHeap>(&design), &data);
        prop_assert_eq!(bits((theta, variance)), bits((dynamic.0, dynamic.1)));

        let window = WindowDesign { samples: 9, prior_variance: 100.0 };
        let (theta, variance, _) =
            run(WindowRls::<f64, Static<N, 9>>::new(N, &window).unwrap(), &data);
        let dynamic = run(WindowRls::<f64>::new(N, &window).unwrap(), &data);
        prop_assert_eq!(bits((theta, variance)), bits((dynamic.0, dynamic.1)));
    }

    #[test]
    fn a_window_is_batch_least_squares_over_its_samples(
        seed: u64, rows in 1_usize..300, samples in 5_usize..40,
    ) {
        let data = data(seed, rows);
        let prior_variance = 100.0;
        let kernel = WindowRls::<f64>::new(N, &WindowDesign { samples, prior_variance }).unwrap();
        let found = run(kernel, &data);
        let last = &data[rows.saturating_sub(samples)..];
        let (theta, variance) = batch(last, |_| 1.0, 1.0 / prior_variance);
        // Short windows come near singular, and each of at most `samples` downdates costs digits.
        close(&found.0, &theta, 1e-8)?;
        close(&found.1, &variance, 1e-8)?;
    }

    #[test]
    fn reset_and_restore_give_the_same_future_to_the_bit(
        seed: u64, forgetting in any_forgetting(),
    ) {
        let data = data(seed, 80);
        let design = RlsDesign { prior_variance: 100.0, forgetting, guard: Guard::default() };
        same_future(&rls::<UdHeap>(&design), &data)?;
        same_future(&rls::<Conventional<f64, Static<N>>>(&design), &data)?;
        let window = WindowDesign { samples: 13, prior_variance: 100.0 };
        same_future(&WindowRls::<f64>::new(N, &window).unwrap(), &data)?;
    }
}

fn same_future<K: RlsKernel<f64>>(
    fresh: &K,
    data: &[([f64; N], f64)],
) -> Result<(), TestCaseError> {
    let continued = |mut kernel: K, mut theta: [f64; N]| {
        for (phi, y) in &data[40..] {
            kernel.update(phi, *y, &mut theta);
        }
        (theta.map(f64::to_bits), kernel.guard())
    };
    let (theta, _, mut half) = run(fresh.clone(), &data[..40]);
    let mut restored = fresh.clone();
    Snapshot::of(&mut half).restore(&mut restored).unwrap();
    let end = continued(half.clone(), theta);
    prop_assert_eq!(continued(restored, theta), end);
    half.reset();
    let (theta, _, again) = run(half, &data[..40]);
    prop_assert_eq!(continued(again, theta), end);
    Ok(())
}

/// A place beyond the window, from a foreign snapshot, once was a panic.
#[test]
fn no_memory_makes_a_window_panic() {
    let data = data(3, 40);
    let design = WindowDesign { samples: 7, prior_variance: 100.0 };
    let mut kernel = WindowRls::<f64>::new(N, &design).unwrap();
    let mut theta = [0.0; N];
    nonsense(&mut kernel, data.len(), |kernel, k| {
        if k == 0 {
            theta = [0.0; N];
        }
        kernel.update(&data[k].0, data[k].1, &mut theta);
        theta.map(f64::to_bits)
    });
}

/// The only sample that tells about a direction leaves the window.
#[test]
fn a_window_is_factorised_again_when_downdating_would_lose_the_digits() {
    let design = WindowDesign { samples: 7, prior_variance: 1e10 };
    let mut data: Vec<([f64; N], f64)> = data(6, 20).into_iter().collect();
    for (k, (phi, _)) in data.iter_mut().enumerate() {
        phi[3] = if k == 10 { 10.0 } else { 0.0 };
    }
    let (theta, variance, kernel) = run(WindowRls::<f64>::new(N, &design).unwrap(), &data);
    let (expected, expected_variance) = batch(&data[13..], |_| 1.0, 1e-10);
    // Condition after the scaling of the columns about 1e2, downdates included.
    close(&theta, &expected, 1e-8).unwrap();
    close(&variance, &expected_variance, 1e-8).unwrap();
    let (_, _, before) = run(WindowRls::<f64>::new(N, &design).unwrap(), &data[..17]);
    let (_, _, after) = run(WindowRls::<f64>::new(N, &design).unwrap(), &data[..18]);
    assert_eq!((before.guard().bounded, after.guard().bounded), (0, 1));
    assert_eq!(kernel.guard().bounded, 1);
}

#[test]
fn settings_out_of_range_are_named() {
    let message = |forgetting| {
        Rls::<f64, UdHeap>::new(N, &RlsDesign::forgetting(forgetting)).unwrap_err().to_string()
    };
    assert_eq!(
        message(Forgetting::Exponential { lambda: 1.5 }),
        "forgetting factor must be above 0 and at most 1, got 1.5"
    );
    assert_eq!(
        message(Forgetting::Equation18 { alpha: 0.0, falling: None }),
        "alpha of eq. (18) must be positive and finite, got 0"
    );
    let limited = |trace_limit| {
        let guard = Guard { trace_limit, ..Guard::default() };
        Rls::<f64, UdHeap>::new(N, &RlsDesign { guard, ..RlsDesign::default() })
    };
    let message = limited(0.5).unwrap_err().to_string();
    assert_eq!(message, "trace limit must be at least 1, got 0.5");
    assert!(limited(1.0).is_ok() && limited(f64::NAN).is_err());
    let wrong_size = Rls::<f64, Ud<f64, Static<3>>>::new(N, &RlsDesign::default()).unwrap_err();
    assert_eq!(wrong_size.to_string(), "factor U must be 3x3, got 4x4");
    let parsed: Result<Forgetting, _> = serde_json::from_str(r#"{"kind":"exponentiel"}"#);
    assert!(parsed.unwrap_err().to_string().contains("`exponential`"));
}

/// Written once for any storage: the trait bounds are all that a user has to repeat.
#[test]
fn storage_is_chosen_by_one_type() {
    fn learn<S: RlsStorage<f64>>() -> [f64; N] {
        run(rls::<Ud<f64, S>>(&RlsDesign::default()), &data(3, 50)).0
    }
    assert_eq!(learn::<Heap>().map(f64::to_bits), learn::<Static<N>>().map(f64::to_bits));
}
