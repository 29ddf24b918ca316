//! The time-varying `α(k)` of eq. (18) of Patton & Chen (1992).
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use crate::common::noise;
use faer::{Col, Mat, Scale};
use fd_core::{Heap, Snapshot, stage::Stage};
use fd_ident::{
    batch::BatchRls,
    rls::{ConventionalRls, Falling, Forgetting, Guard, QrRls, RlsDesign, RlsKernel, UdRls},
};
use fd_numeric::dense::Dense;
use proptest::prelude::*;

const N: usize = 3;

fn design(alpha: f64, ratio: f64, least: f64, prior_variance: f64) -> RlsDesign {
    let forgetting = Forgetting::Equation18 { alpha, falling: Some(Falling { ratio, least }) };
    RlsDesign { prior_variance, forgetting, guard: Guard::off() }
}

/// Two samples by hand, `α(1) = 4` and `α(2) = 2`. The first is that of a constant `α`: `P(1) = 4/11`,
/// `θ(1) = 20/11`. Then `φ = 1` and `μ = 3` make `P(2)⁻¹ = 11/4 + 1/2`, hence `P(2) = 4/13`,
/// `K = (4/13)/2 = 2/13` and `θ(2) = 20/11 + (2/13)(3 − 20/11) = 2`.
#[test]
fn two_samples_by_hand() {
    fn check(mut kernel: impl RlsKernel<f64>) {
        let (mut theta, mut variance) = ([1.0], [0.0]);
        kernel.update(&[3.0], 6.0, &mut theta);
        kernel.update(&[1.0], 3.0, &mut theta);
        kernel.variance_into(&mut variance);
        // A handful of roundings.
        assert!((theta[0] - 2.0).abs() < 1e-14, "{theta:?}");
        assert!((variance[0] - 4.0 / 13.0).abs() < 1e-14, "{variance:?}");
    }
    let design = design(4.0, 0.5, 1e-3, 2.0);
    check(UdRls::<f64, Heap>::new(1, &design).unwrap());
    check(ConventionalRls::<f64, Heap>::new(1, &design).unwrap());
    check(QrRls::<f64, Heap>::new(1, &design).unwrap());
}

/// `θ` and the diagonal of `P` after the last sample, from (18a) to (18c) with `alpha(k)`.
fn as_printed(alpha: impl Fn(usize) -> f64, prior: f64, data: &[f64]) -> ([f64; N], [f64; N]) {
    let mut information = Scale(prior.recip()) * Mat::<f64>::identity(N, N);
    let mut theta = Col::<f64>::zeros(N);
    for (k, row) in data.chunks_exact(N + 1).enumerate() {
        let inverse = alpha(k).recip();
        let phi = Col::from_fn(N, |i| row[i]);
        information += Scale(inverse) * &phi * phi.transpose();
        let gain = Scale(inverse) * information.lu().inverse() * &phi;
        theta += Scale(row[N] - theta.transpose() * &phi) * gain;
    }
    let p = information.lu().inverse();
    (std::array::from_fn(|i| theta[i]), std::array::from_fn(|i| p[(i, i)]))
}

fn run(kernel: &mut impl RlsKernel<f64>, data: &[f64], theta: &mut [f64; N]) -> [f64; N] {
    for row in data.chunks_exact(N + 1) {
        kernel.update(&row[..N], row[N], theta);
    }
    let mut variance = [0.0; N];
    kernel.variance_into(&mut variance);
    variance
}

/// Information matrices of a condition up to 1e4 lose four digits of sixteen, some hundred roundings two
/// more.
fn close(found: &[f64; N], expected: &[f64; N]) -> Result<(), TestCaseError> {
    let size = expected.iter().fold(0.0_f64, |size, v| size.max(v.abs()));
    for (found, expected) in found.iter().zip(expected) {
        prop_assert!((found - expected).abs() <= 1e-9 * size, "{found}, not {expected}");
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, failure_persistence: None, ..Default::default() })]

    #[test]
    fn every_kernel_follows_the_printed_equations(
        seed: u64, alpha in 0.1..10.0, ratio in 0.9..1.0_f64, share in 0.05..1.0,
    ) {
        let data = noise(seed, 60 * (N + 1));
        let least = share * alpha;
        let course = |k: usize| (0..k).fold(alpha, |alpha: f64, _| (ratio * alpha).max(least));
        let (theta, variance) = as_printed(course, 100.0, &data);
        let design = design(alpha, ratio, least, 100.0);
        let (mut a, mut b, mut c) = ([0.0; N], [0.0; N], [0.0; N]);
        close(&run(&mut UdRls::<f64>::new(N, &design).unwrap(), &data, &mut a), &variance)?;
        close(&run(&mut ConventionalRls::<f64>::new(N, &design).unwrap(), &data, &mut b), &variance)?;
        close(&run(&mut QrRls::<f64>::new(N, &design).unwrap(), &data, &mut c), &variance)?;
        for found in [a, b, c] {
            close(&found, &theta)?;
        }
    }

    /// With `α(k) = α λᵏ` and `P₀' = λ P₀/α`, exponential forgetting is eq. (18) with `P` counted in units
    /// of the present `α`.
    #[test]
    fn a_geometric_alpha_is_exponential_forgetting(
        seed: u64, alpha in 0.1..10.0, lambda in 0.9..1.0_f64, rows in 1_usize..120,
    ) {
        let data = noise(seed, rows * (N + 1));
        let mut paper = UdRls::<f64>::new(N, &design(alpha, lambda, 1e-9 * alpha, 100.0)).unwrap();
        let exponential = RlsDesign {
            prior_variance: 100.0 * lambda / alpha,
            forgetting: Forgetting::Exponential { lambda },
            guard: Guard::off(),
        };
        let mut other = UdRls::<f64>::new(N, &exponential).unwrap();
        let (mut a, mut b) = ([0.0; N], [0.0; N]);
        let paper = run(&mut paper, &data, &mut a);
        let other = run(&mut other, &data, &mut b);
        close(&a, &b)?;
        let last = (1..rows).fold(alpha, |alpha: f64, _| lambda * alpha);
        close(&paper, &other.map(|p| last * p))?;
    }

    #[test]
    fn a_snapshot_holds_alpha(seed: u64, cut in 0_usize..80) {
        let data = noise(seed, 80 * (N + 1));
        let (before, after) = data.split_at(cut * (N + 1));
        let fresh = UdRls::<f64>::new(N, &design(1.0, 0.95, 0.1, 100.0)).unwrap();
        let (mut one, mut theta) = (fresh.clone(), [0.0; N]);
        run(&mut one, before, &mut theta);
        let (mut two, mut again) = (fresh, theta);
        Snapshot::of(&mut one).restore(&mut two).unwrap();
        let expected = run(&mut one, after, &mut theta);
        prop_assert_eq!(run(&mut two, after, &mut again).map(f64::to_bits), expected.map(f64::to_bits));
        prop_assert_eq!(again.map(f64::to_bits), theta.map(f64::to_bits));
        // And a reset brings the first α back.
        let (mut first, mut second) = ([0.0; N], [0.0; N]);
        one.reset();
        run(&mut one, before, &mut first);
        run(&mut UdRls::<f64>::new(N, &design(1.0, 0.95, 0.1, 100.0)).unwrap(), before, &mut second);
        prop_assert_eq!(first.map(f64::to_bits), second.map(f64::to_bits));
    }
}

/// "The tracking speed can be improved by changing the forgetting factor": parameters jump after 1000
/// samples, and 100 samples later the error is what the weights of the samples leave of the jump.
#[test]
fn a_falling_alpha_tracks_and_a_constant_one_does_not() {
    let numbers = noise(1992, 1100 * (N + 1));
    let mut data = numbers.clone();
    for (k, row) in data.chunks_exact_mut(N + 1).enumerate() {
        let slope = if k < 1000 { 1.0 } else { 2.0 };
        row[N] = slope * (row[0] + row[1] + row[2]);
    }
    let error = |kernel: &mut UdRls<f64>, data: &[f64], theta: &mut [f64; N]| {
        run(kernel, data, theta);
        theta.iter().fold(0.0_f64, |worst, v| worst.max((v - 2.0).abs()))
    };
    let mut constant = UdRls::<f64>::new(N, &design(1.0, 1.0, 1.0, 1e6)).unwrap();
    let mut falling = UdRls::<f64>::new(N, &design(1.0, 0.98, 1e-12, 1e6)).unwrap();
    let slow = error(&mut constant.clone(), &data, &mut [0.0; N]);
    let fast = error(&mut falling, &data, &mut [0.0; N]);
    // 1000 of 1100 samples know the old value; with 0.98¹⁰⁰ = 0.13 of its weight left it is the other way
    // round. Regressors that are not orthogonal spread both by some tenths.
    assert!((0.8..1.0).contains(&slow) && fast < 0.25, "{slow} {fast}");
    // The same by hand: α is set when somebody knows of the change.
    let (before, after) = data.split_at(1000 * (N + 1));
    let mut theta = [0.0; N];
    run(&mut constant, before, &mut theta);
    constant.set_alpha(1e-3);
    // The design says that α is at least 1, so only the next sample has the weight of the old thousand.
    let one = error(&mut constant.clone(), &after[..=N], &mut theta.clone());
    for row in after.chunks_exact(N + 1) {
        constant.set_alpha(1e-3);
        run(&mut constant, row, &mut theta);
    }
    let all = theta.iter().fold(0.0_f64, |worst, v| worst.max((v - 2.0).abs()));
    assert!(one > 0.1 && all < 0.05, "{one} {all}");
}

/// Other kinds have no `α`, and nonsense is not one.
#[test]
fn set_alpha_changes_nothing_else() {
    let data = noise(5, 40 * (N + 1));
    let plain = RlsDesign::default();
    let paper = design(2.0, 0.9, 0.5, 1e6);
    for (design, values) in [(plain, vec![0.01]), (paper, vec![0.0, -1.0, f64::NAN, f64::INFINITY])]
    {
        let fresh = UdRls::<f64>::new(N, &design).unwrap();
        let (mut a, mut b) = ([0.0; N], [0.0; N]);
        run(&mut fresh.clone(), &data, &mut a);
        let mut set = fresh;
        for alpha in values {
            set.set_alpha(alpha);
        }
        run(&mut set, &data, &mut b);
        assert_eq!(a.map(f64::to_bits), b.map(f64::to_bits));
    }
}

/// A sample is silent next to the `α` that it meets, not next to the first one.
#[test]
fn silence_follows_alpha() {
    let forgetting =
        Forgetting::Equation18 { alpha: 16.0, falling: Some(Falling { ratio: 0.1, least: 1.0 }) };
    let design = RlsDesign { prior_variance: 1.0, forgetting, guard: Guard::default() };
    // φᵀPφ = 4 ε along an axis that nothing else excites.
    let quiet = [0.0, 2.0 * f64::EPSILON.sqrt()];
    let mut kernel = UdRls::<f64>::new(2, &design).unwrap();
    let mut theta = [0.0; 2];
    kernel.update(&quiet, 1.0, &mut theta);
    assert_eq!(kernel.guard().skipped, 1, "next to 16");
    kernel.update(&[1.0, 0.0], 1.0, &mut theta);
    kernel.update(&quiet, 1.0, &mut theta);
    assert_eq!(kernel.guard().skipped, 1, "next to 1.6");
}

#[test]
fn settings_out_of_range_are_named() {
    let refused = |ratio, least| {
        UdRls::<f64>::new(N, &design(1.0, ratio, least, 1.0)).unwrap_err().to_string()
    };
    assert_eq!(
        refused(1.1, 0.5),
        "falling.ratio of eq. (18) must be above 0 and at most 1, got 1.1"
    );
    assert_eq!(
        refused(0.9, 2.0),
        "falling.least of eq. (18) must be positive, at most alpha, got 2"
    );
    assert!(
        refused(f64::NAN, 0.5).contains("falling.ratio") && refused(0.9, 0.0).contains("least")
    );
    let batch = BatchRls::<f64>::new(N, 2, &design(1.0, 0.9, 0.5, 1.0)).unwrap_err().to_string();
    assert!(batch.contains("equation18 with a falling alpha"), "{batch}");
}
