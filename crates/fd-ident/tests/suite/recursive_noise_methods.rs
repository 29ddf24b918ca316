//! Identities of the recursive estimators for noise, and their memory.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use crate::common::{bits, noise};
use fd_core::{Snapshot, stage::Identifier};
use fd_ident::{
    arx::{ArxOrders, RecursiveArx},
    extended::RecursiveArmax,
    instrumental::{IvDesign, RecursiveIv},
    random_walk::{Drift, KalmanRls, RandomWalkDesign},
    rls::{Forgetting, Guard, RlsDesign, RlsKernel, UdRls},
};
use proptest::prelude::*;

const N: usize = 3;

fn walk(drift: Drift) -> KalmanRls<f64> {
    let design = RandomWalkDesign { prior_variance: 1e3, drift, guard: Guard::off() };
    KalmanRls::new(N, &design).unwrap()
}

fn plain(forgetting: Forgetting) -> UdRls<f64> {
    let design = RlsDesign { prior_variance: 1e3, forgetting, guard: Guard::off() };
    UdRls::new(N, &design).unwrap()
}

/// The textbook filter on a full matrix.
fn textbook(samples: &[([f64; N], f64)], q: [f64; N]) -> ([f64; N], [[f64; N]; N]) {
    let mut p = [[0.0; N]; N];
    (0..N).for_each(|i| p[i][i] = 1e3);
    let mut theta = [0.0; N];
    for (phi, y) in samples {
        (0..N).for_each(|i| p[i][i] += q[i]);
        let m: Vec<f64> = (0..N).map(|i| (0..N).map(|j| p[i][j] * phi[j]).sum()).collect();
        let s = 1.0 + (0..N).map(|i| phi[i] * m[i]).sum::<f64>();
        let e = y - (0..N).map(|i| phi[i] * theta[i]).sum::<f64>();
        for i in 0..N {
            theta[i] += m[i] / s * e;
            (0..N).for_each(|j| p[i][j] -= m[i] * m[j] / s);
        }
    }
    (theta, p)
}

fn samples() -> impl Strategy<Value = Vec<([f64; N], f64)>> {
    prop::collection::vec((prop::array::uniform3(-1.0..1.0_f64), -1.0..1.0_f64), 1..60)
}

fn run(kernel: &mut impl RlsKernel<f64>, samples: &[([f64; N], f64)]) -> [f64; N] {
    let mut theta = [0.0; N];
    for (phi, y) in samples {
        kernel.update(phi, *y, &mut theta);
    }
    theta
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn without_drift_it_is_least_squares(samples in samples()) {
        let ours = run(&mut walk(Drift::Uniform { variance: 0.0 }), &samples);
        // The very same operations.
        prop_assert_eq!(bits(&ours), bits(&run(&mut plain(Forgetting::None), &samples)));
    }

    #[test]
    fn with_the_matching_drift_it_is_exponential_forgetting(
        samples in samples(),
        lambda in 0.9..1.0_f64,
    ) {
        let ours = run(&mut walk(Drift::Proportional { lambda }), &samples);
        let theirs = run(&mut plain(Forgetting::Exponential { lambda }), &samples);
        for (a, b) in ours.iter().zip(theirs) {
            // P is at most 1e3/0.9^60 = 6e5 wide, so an ε of the sample moves θ by less.
            prop_assert!((a - b).abs() < 1e-8 * (1.0 + b.abs()), "{} {}", a, b);
        }
    }

    #[test]
    fn it_is_the_textbook_filter(
        samples in samples(),
        q in prop::array::uniform3(0.0..1.0_f64),
    ) {
        let mut filter = walk(Drift::PerParameter { variances: q.to_vec() });
        let ours = run(&mut filter, &samples);
        let (theta, p) = textbook(&samples, q);
        let mut variance = [0.0; N];
        filter.variance_into(&mut variance);
        for i in 0..N {
            // The full matrix loses ε · 1e3 per step in the cancellation of its first samples.
            prop_assert!((ours[i] - theta[i]).abs() < 1e-8, "{} {}", ours[i], theta[i]);
            prop_assert!((variance[i] - p[i][i]).abs() < 1e-8 * (1.0 + p[i][i]));
        }
    }
}

/// Scalar, `φ = 1`: the predicted variance tends to the positive root of `M² − q M − q = 0`.
#[test]
fn the_variance_tends_to_the_solution_of_the_riccati_equation() {
    let q = 0.04;
    let drift = Drift::Uniform { variance: q };
    let design = RandomWalkDesign { drift, ..RandomWalkDesign::default() };
    let mut filter = KalmanRls::<f64>::new(1, &design).unwrap();
    let mut theta = [0.0];
    (0..300).for_each(|_| filter.update(&[1.0], 1.0, &mut theta));
    let mut variance = [0.0];
    filter.variance_into(&mut variance);
    let m = 0.5 * (q + (q * q + 4.0 * q).sqrt());
    // P = M − q after the update; the error falls by (1−K)² = 0.67 per sample.
    assert!((variance[0] - (m - q)).abs() < 1e-12, "{} {}", variance[0], m - q);
}

#[test]
fn drift_without_excitation_is_bounded() {
    let drift = Drift::Uniform { variance: 1.0 };
    let design = RandomWalkDesign { prior_variance: 10.0, drift, guard: Guard::default() };
    let mut filter = KalmanRls::<f64>::new(2, &design).unwrap();
    let mut theta = [0.0; 2];
    (0..10_000).for_each(|_| filter.update(&[1.0, 0.0], 1.0, &mut theta));
    let mut variance = [0.0; 2];
    filter.variance_into(&mut variance);
    assert!(variance[1] <= 200.0 && filter.guard().bounded > 0, "{variance:?}");
}

/// Save in the middle, go on, restore and go on again: the same to the bit; and so after a reset.
fn assert_memory(mut identifier: impl Identifier<f64>) {
    let (u, mu) = (noise(5, 600), noise(6, 600));
    let feed = |identifier: &mut dyn Identifier<f64>, range: std::ops::Range<usize>| {
        range.for_each(|k| identifier.update(&u[k..=k], &mu[k..=k]));
        let mut variance = vec![0.0; identifier.theta().len()];
        identifier.variance_into(&mut variance);
        (bits(identifier.theta()), bits(&variance), identifier.guard())
    };
    feed(&mut identifier, 0..300);
    let saved = Snapshot::of(&mut identifier);
    let first = feed(&mut identifier, 300..600);
    saved.restore(&mut identifier).unwrap();
    assert_eq!(feed(&mut identifier, 300..600), first);
    identifier.reset();
    feed(&mut identifier, 0..300);
    assert_eq!(feed(&mut identifier, 300..600), first);
}

#[test]
fn what_they_remember_is_all_that_counts() {
    let orders = ArxOrders::new(2, 2, 1).with_offset();
    let n = orders.parameters(1);
    assert_memory(RecursiveIv::<f64>::new(orders, 1, 1, &IvDesign::default()).unwrap());
    let kernel = UdRls::<f64>::new(n + 2, &RlsDesign::default()).unwrap();
    assert_memory(RecursiveArmax::new(orders, 2, 1, 1, kernel).unwrap());
    let drift = Drift::Uniform { variance: 1e-4 };
    let design = RandomWalkDesign { drift, ..RandomWalkDesign::default() };
    let kernel = KalmanRls::<f64>::new(n, &design).unwrap();
    assert_memory(RecursiveArx::new(orders, 1, 1, kernel).unwrap());
}

/// Without noise in the equation, extended and instrumental estimates end at the truth too.
#[test]
fn exact_data_are_learned_exactly() {
    let u = noise(7, 3000);
    let orders = ArxOrders::new(1, 1, 0);
    let kernel = UdRls::<f64>::new(3, &RlsDesign::default()).unwrap();
    let mut extended = RecursiveArmax::new(orders, 1, 1, 1, kernel).unwrap();
    let mut iv = RecursiveIv::<f64>::new(orders, 1, 1, &IvDesign::default()).unwrap();
    let mut mu = 0.0;
    for u in u {
        mu = 0.7 * mu + 2.0 * u;
        extended.update(&[u], &[mu]);
        iv.update(&[u], &[mu]);
    }
    for theta in [extended.theta(), iv.theta()] {
        // The prior weighs 1e-8 against 3000 samples.
        assert!((theta[0] + 0.7).abs() < 1e-6 && (theta[1] - 2.0).abs() < 1e-6, "{theta:?}");
    }
}
