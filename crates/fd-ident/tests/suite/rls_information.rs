//! Forgetting and the QR factor against their definitions on the information matrix.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use crate::common::noise;
use faer::Mat;
use fd_core::Heap;
use fd_ident::rls::{Forgetting, Guard, QrRls, Rls, RlsDesign, RlsKernel, Ud};
use fd_numeric::dense::Dense;

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

fn rls(design: &RlsDesign) -> Rls<f64, Ud<f64, Heap>> {
    Rls::new(N, design).unwrap()
}

/// Kulhavý's step against its definition on the information matrix.
#[test]
fn directional_forgetting_changes_the_information_along_the_regressor() {
    let lambda = 0.95;
    let forgetting = Forgetting::Directional { lambda };
    let design = RlsDesign { prior_variance: 0.1, forgetting, guard: Guard::default() };
    let mut kernel = rls(&design);
    let mut information = Mat::<f64>::identity(N, N) * faer::Scale(10.0);
    let (mut theta, mut signs) = ([0.0; N], [0, 0]);
    for (phi, y) in data(5, 200) {
        let phi_vector = faer::Col::from_fn(N, |i| phi[i]);
        let energy = phi_vector.transpose() * inverse(&information) * &phi_vector;
        let weight = lambda - (1.0 - lambda) / energy;
        signs[usize::from(weight > 0.0)] += 1;
        information += faer::Scale(weight) * &phi_vector * phi_vector.transpose();
        kernel.update(&phi, y, &mut theta);
        let mut variance = [0.0; N];
        kernel.variance_into(&mut variance);
        let expected = inverse(&information);
        for i in 0..N {
            assert!((variance[i] - expected[(i, i)]).abs() < 1e-10 * expected[(i, i)]);
        }
    }
    // Both branches, taking in and giving up, have been tried.
    assert!(signs[0] > 50 && signs[1] > 50, "{signs:?}");
}

/// Where the trace is above its limit, samples that would give up information change none, and only they are counted.
#[test]
fn directional_forgetting_pauses_at_the_limit_of_the_trace() {
    let (lambda, prior_variance) = (0.9, 0.01);
    let forgetting = Forgetting::Directional { lambda };
    let guard = Guard { trace_limit: 1.0, ..Guard::default() };
    let mut kernel = rls(&RlsDesign { prior_variance, forgetting, guard });
    let mut information = Mat::<f64>::identity(N, N) * faer::Scale(1.0 / prior_variance);
    let (mut theta, mut paused, mut learned) = ([0.0; N], 0, 0);
    for (k, (phi, y)) in data(9, 400).into_iter().enumerate() {
        // Quiet samples give up, every seventh takes in.
        let phi = phi.map(|v| if k % 7 == 6 { 5.0 * v } else { v });
        let phi_vector = faer::Col::from_fn(N, |i| phi[i]);
        let covariance = inverse(&information);
        let energy = phi_vector.transpose() * &covariance * &phi_vector;
        let trace: f64 = (0..N).map(|i| covariance[(i, i)]).sum();
        let weight = lambda - (1.0 - lambda) / energy;
        // The trace of the prior is its limit to the bit.
        let is_above = trace > N as f64 * prior_variance * (1.0 + 1e-12);
        if weight < 0.0 && is_above {
            paused += 1;
        } else {
            information += faer::Scale(weight) * &phi_vector * phi_vector.transpose();
        }
        learned += u64::from(weight > 0.0 && is_above);
        kernel.update(&phi, y, &mut theta);
        let mut variance = [0.0; N];
        kernel.variance_into(&mut variance);
        let expected = inverse(&information);
        for i in 0..N {
            assert!((variance[i] - expected[(i, i)]).abs() < 1e-10 * expected[(i, i)]);
        }
        assert_eq!(kernel.guard().bounded, paused);
    }
    // Above the limit both kinds of samples have been seen.
    assert!(paused > 20 && learned > 3, "{paused} {learned}");
}

/// Exponential forgetting, and with each sample `n (1−λ)/c` more of information about the parameter whose turn it is.
#[test]
fn bounded_forgetting_adds_information_axis_by_axis() {
    let (lambda, bound) = (0.9, 5.0);
    let forgetting = Forgetting::Bounded { lambda, variance: bound };
    let design = RlsDesign { prior_variance: 0.5, forgetting, guard: Guard::default() };
    let mut kernel = rls(&design);
    let mut information = Mat::<f64>::identity(N, N) * faer::Scale(2.0);
    let mut theta = [0.0; N];
    for (k, (phi, y)) in data(7, 60).iter().enumerate() {
        let phi_vector = faer::Col::from_fn(N, |i| phi[i]);
        information *= faer::Scale(lambda);
        information += &phi_vector * phi_vector.transpose();
        information[(k % N, k % N)] += N as f64 * (1.0 - lambda) / bound;
        kernel.update(phi, *y, &mut theta);
        let mut variance = [0.0; N];
        kernel.variance_into(&mut variance);
        let expected = inverse(&information);
        for i in 0..N {
            // Of a condition below 1e3: some hundred roundings.
            assert!((variance[i] - expected[(i, i)]).abs() < 1e-10 * expected[(i, i)], "{k}, {i}");
        }
    }
}

/// Of `R` with `RᵀR` the information: `tr P = ‖R⁻¹‖²`, and `‖R‖² = tr P⁻¹`, in Frobenius norms.
#[test]
fn trace_and_condition_of_the_factor_are_those_of_its_inverse() {
    let design = RlsDesign { prior_variance: 10.0, ..RlsDesign::default() };
    let mut information = Mat::<f64>::identity(N, N) * faer::Scale(0.1);
    let (mut kernel, mut theta) = (QrRls::<f64>::new(N, &design).unwrap(), [0.0; N]);
    for (phi, y) in data(8, 30) {
        let phi_vector = faer::Col::from_fn(N, |i| phi[i]);
        information += &phi_vector * phi_vector.transpose();
        kernel.update(&phi, y, &mut theta);
        let covariance = inverse(&information);
        let trace = |of: &Mat<f64>| (0..N).map(|i| of[(i, i)]).sum::<f64>();
        let (spread, condition) =
            (trace(&covariance), (trace(&information) * trace(&covariance)).sqrt());
        // Of a condition of at most 1e3: some hundred roundings.
        assert!((kernel.trace() / spread - 1.0).abs() < 1e-10, "{} {spread}", kernel.trace());
        assert!((kernel.condition() / condition - 1.0).abs() < 1e-10, "{condition}");
    }
}

fn inverse(matrix: &Mat<f64>) -> Mat<f64> {
    matrix.lu().inverse()
}
