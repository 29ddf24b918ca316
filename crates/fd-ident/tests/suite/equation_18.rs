//! Eq. (18) of Patton & Chen (1992) as printed, against every kernel that has it.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use crate::common::noise;
use faer::{Col, Mat, Scale};
use fd_core::Heap;
use fd_ident::{
    batch::{BatchRls, SampleBlock},
    rls::{ConventionalRls, Forgetting, Guard, QrRls, RlsDesign, RlsKernel, UdRls},
};
use fd_numeric::dense::Dense;

const N: usize = 3;
const SAMPLES: usize = 40;

fn design(alpha: f64, prior_variance: f64) -> RlsDesign {
    let forgetting = Forgetting::Equation18 { alpha, falling: None };
    RlsDesign { prior_variance, forgetting, guard: Guard::default() }
}

/// One sample by hand: `P(0) = 2`, `α = 4`, `φ = 3`, `μ = 6` and `θ(0) = 1` make
/// `P(1)⁻¹ = 1/2 + 9/4`, hence `P(1) = 4/11`, `K = (4/11)(3/4) = 3/11` and
/// `θ(1) = 1 + (3/11)(6 − 3) = 20/11`.
#[test]
fn one_sample_by_hand() {
    fn check(mut kernel: impl RlsKernel<f64>) {
        let (mut theta, mut variance) = ([1.0], [0.0]);
        kernel.update(&[3.0], 6.0, &mut theta);
        kernel.variance_into(&mut variance);
        assert!((theta[0] - 20.0 / 11.0).abs() < 1e-15, "{theta:?}");
        assert!((variance[0] - 4.0 / 11.0).abs() < 1e-15, "{variance:?}");
    }
    let design = design(4.0, 2.0);
    check(UdRls::<f64, Heap>::new(1, &design).unwrap());
    check(ConventionalRls::<f64, Heap>::new(1, &design).unwrap());
    check(QrRls::<f64, Heap>::new(1, &design).unwrap());
}

/// A sample is silent when its `φᵀPφ` is below the rounding of the `α` that it is added to.
#[test]
fn silence_is_measured_by_alpha() {
    fn skipped(mut kernel: impl RlsKernel<f64>) -> u64 {
        // φᵀPφ = 4 ε.
        kernel.update(&[2.0 * f64::EPSILON.sqrt()], 1.0, &mut [0.0]);
        kernel.guard().skipped
    }
    for (alpha, expected) in [(16.0, 1), (3.0, 0), (0.25, 0)] {
        let design = design(alpha, 1.0);
        assert_eq!(skipped(UdRls::<f64, Heap>::new(1, &design).unwrap()), expected, "{alpha}");
        let conventional = ConventionalRls::<f64, Heap>::new(1, &design).unwrap();
        assert_eq!(skipped(conventional), expected, "{alpha}");
        let mut batch = BatchRls::<f64>::new(1, 1, &design).unwrap();
        let mut block = SampleBlock::new(1, 1, 1);
        block.set(0, 0, &[2.0 * f64::EPSILON.sqrt()], 1.0);
        batch.update(&block).unwrap();
        assert_eq!(batch.guard(0).skipped, expected, "{alpha}");
    }
}

/// `θ(k)` and the diagonal of `P(k)` after each sample, in the order of the equations:
///
/// ```text
/// P(k)⁻¹ = P(k−1)⁻¹ + φ(k) φᵀ(k) / α(k)                      (18b)
/// K(k)   = P(k) φ(k) / α(k)                                  (18c)
/// θ(k)   = θ(k−1) + K(k) [μ(k) − θᵀ(k−1) φ(k)]               (18a)
/// ```
fn as_printed(
    alpha: impl Fn(i32) -> f64,
    prior_variance: f64,
    data: &[f64],
) -> Vec<([f64; N], [f64; N])> {
    let mut information = Scale(prior_variance.recip()) * Mat::<f64>::identity(N, N);
    let mut theta = Col::<f64>::zeros(N);
    data.chunks_exact(N + 1)
        .zip(0..)
        .map(|(row, k)| {
            let alpha = alpha(k);
            let phi = Col::from_fn(N, |i| row[i]);
            information += Scale(alpha.recip()) * &phi * phi.transpose();
            let p = information.lu().inverse();
            let gain = Scale(alpha.recip()) * &p * &phi;
            let innovation = row[N] - theta.transpose() * &phi;
            theta += Scale(innovation) * gain;
            (std::array::from_fn(|i| theta[i]), std::array::from_fn(|i| p[(i, i)]))
        })
        .collect()
}

fn assert_close(what: &str, found: &[f64], expected: &[f64]) {
    for (found, expected) in found.iter().zip(expected) {
        // Information matrices of a condition up to 1e4 lose four digits of sixteen; some hundred
        // roundings on the way, two more.
        let tolerance = 1e-10 * expected.abs().max(1e-3);
        assert!((found - expected).abs() < tolerance, "{what}: {found}, not {expected}");
    }
}

fn follow(
    what: &str,
    mut kernel: impl RlsKernel<f64>,
    data: &[f64],
    expected: &[([f64; N], [f64; N])],
) {
    let (mut theta, mut variance) = ([0.0; N], [0.0; N]);
    for (row, (expected_theta, expected_variance)) in data.chunks_exact(N + 1).zip(expected) {
        kernel.update(&row[..N], row[N], &mut theta);
        kernel.variance_into(&mut variance);
        assert_close(what, &theta, expected_theta);
        assert_close(what, &variance, expected_variance);
    }
}

/// Sample by sample, for values of `α` on both sides of one; none of them is a forgetting that the
/// limit of the trace would hold back.
#[test]
fn every_sample_as_printed() {
    let data = noise(18, SAMPLES * (N + 1));
    for alpha in [0.05, 0.25, 1.0, 3.0] {
        let expected = as_printed(|_| alpha, 100.0, &data);
        let design = design(alpha, 100.0);
        follow("UD", UdRls::<f64, Heap>::new(N, &design).unwrap(), &data, &expected);
        follow("P", ConventionalRls::<f64, Heap>::new(N, &design).unwrap(), &data, &expected);
        follow("QR", QrRls::<f64, Heap>::new(N, &design).unwrap(), &data, &expected);
    }
}

/// The same for estimators side by side, each with data of its own.
#[test]
fn side_by_side_as_printed() {
    let estimators = 5;
    for alpha in [0.25, 3.0] {
        let mut batch = BatchRls::<f64>::new(N, estimators, &design(alpha, 100.0)).unwrap();
        let mut block = SampleBlock::new(N, estimators, SAMPLES);
        let data = |estimator: usize| noise(estimator as u64, SAMPLES * (N + 1));
        for estimator in 0..estimators {
            for (step, row) in data(estimator).chunks_exact(N + 1).enumerate() {
                block.set(estimator, step, &row[..N], row[N]);
            }
        }
        batch.update(&block).unwrap();
        for estimator in 0..estimators {
            let all = as_printed(|_| alpha, 100.0, &data(estimator));
            let (theta, variance) = all.last().unwrap();
            let (mut found, mut found_variance) = ([0.0; N], [0.0; N]);
            batch.theta_into(estimator, &mut found);
            batch.variance_into(estimator, &mut found_variance);
            assert_close("side by side", &found, theta);
            assert_close("side by side", &found_variance, variance);
        }
    }
}
