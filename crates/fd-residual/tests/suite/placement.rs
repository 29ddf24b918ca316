//! Pole placement: the poles land where they are wanted, and bad requests are refused.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common::{Draw, draws, plant, pole_distance, rng, sampled};
use faer::{Mat, c64, mat};
use fd_model::{ModelError, StateSpace};
use fd_numeric::dense::DenseReal;
use fd_residual::{
    DesignError,
    observer::{ObserverDesign, place_poles},
};
use proptest::prelude::*;
use rand::RngExt;

/// Poles within radius 0.8: `pairs` conjugate pairs, the others real, all apart.
fn wanted(seed: u64, n: usize, pairs: usize) -> Vec<c64> {
    let mut rng = rng(seed);
    let mut poles = Vec::new();
    for _ in 0..pairs.min(n / 2) {
        let pole = c64::new(rng.random_range(-0.6..0.6), rng.random_range(0.1..0.5));
        poles.extend([pole, pole.conj()]);
    }
    while poles.len() < n {
        let re = rng.random_range(-0.8..0.8);
        poles.push(c64::new(re, 0.0));
    }
    poles
}

/// How far eigenvalues of condition `condition` may be off after rounding of size `eps ‖A‖`
/// (Bauer and Fike), with a factor for the growth in forming X Λ X⁻¹ and solving for L.
fn tolerance(condition: f64, norm: f64, n: usize) -> f64 {
    100.0 * n as f64 * f64::EPSILON * condition * condition * norm
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn poles_land_where_they_are_wanted(draw in draws(), pairs in 0..=3_usize) {
        let model = plant(draw);
        let poles = wanted(draw.seed ^ 3, draw.nx, pairs);
        let placement = match place_poles(model.a(), model.c(), &poles) {
            // Nearly equal poles for a single output have no independent eigenvectors.
            Err(DesignError::PlacementCondition { .. } | DesignError::Unobservable { .. }) => {
                return Err(TestCaseError::reject("ill-conditioned draw"));
            }
            placement => placement.unwrap(),
        };
        let closed = model.a() - &placement.gain * model.c();
        let norm = model.a().norm_l2() + placement.gain.norm_l2() * model.c().norm_l2();
        let error = pole_distance(&closed.modes().unwrap(), &poles);
        let allowed = tolerance(placement.condition, norm, draw.nx);
        prop_assert!(error < allowed, "{error:e} > {allowed:e}, {placement:?}");
    }

    /// Poles may be repeated up to the rank of C.
    #[test]
    fn poles_may_repeat(draw in draws()) {
        prop_assume!(2 <= draw.ny && 2 <= draw.nx);
        let model = plant(draw);
        let mut poles = wanted(draw.seed ^ 3, draw.nx, 0);
        let multiplicity = draw.ny.min(draw.nx);
        poles[..multiplicity].fill(c64::new(0.25, 0.0));
        let placement = place_poles(model.a(), model.c(), &poles).unwrap();
        let closed = model.a() - &placement.gain * model.c();
        let norm = model.a().norm_l2() + placement.gain.norm_l2() * model.c().norm_l2();
        let error = pole_distance(&closed.modes().unwrap(), &poles);
        prop_assert!(error < tolerance(placement.condition, norm, draw.nx), "{error:e}");
    }

    /// With as many outputs as states the eigenvectors can be orthogonal.
    #[test]
    fn full_measurement_is_perfectly_conditioned(draw in draws(), pairs in 0..=3_usize) {
        let model = plant(Draw { ny: draw.nx, ..draw });
        let poles = wanted(draw.seed ^ 3, draw.nx, pairs);
        let placement = place_poles(model.a(), model.c(), &poles).unwrap();
        prop_assert!(placement.condition < 1.0 + 1e-6, "{}", placement.condition);
    }
}

/// Kautsky, Nichols and Van Dooren (1985), example 2: a distillation column.
///
/// The reference condition numbers are of `scipy.signal.place_poles` 1.17.1 (method YT, rtol
/// 1e-9), which maximises the same determinant by other steps.
#[test]
fn a_published_column_is_as_robust_as_the_reference() {
    let a = mat![
        [-0.1094, 0.0628, 0.0, 0.0, 0.0],
        [1.306, -2.132, 0.9807, 0.0, 0.0],
        [0.0, 1.595, -3.149, 1.547, 0.0],
        [0.0, 0.0355, 2.632, -4.257, 1.855],
        [0.0, 0.00227, 0.0, 0.1636, -0.1625]
    ];
    let b = mat![[0.0, 0.0], [0.0638, 0.0], [0.0838, -0.1396], [0.1004, -0.206], [0.0063, -0.0128]];
    let (re, pair) = (|v| c64::new(v, 0.0), [c64::new(-1.0, 1.0), c64::new(-1.0, -1.0)]);
    let cases = [
        ([re(-0.2), re(-0.5), re(-1.0), pair[0], pair[1]], 39.853_86),
        ([re(-0.2), re(-0.5), re(-1.0), re(-1.5), re(-2.0)], 57.678_61),
    ];
    for (poles, reference) in cases {
        let placement = place_poles(a.transpose(), b.transpose(), &poles).unwrap();
        let closed = a.transpose() - &placement.gain * b.transpose();
        let error = pole_distance(&closed.modes().unwrap(), &poles);
        let norm = a.norm_l2() + placement.gain.norm_l2() * b.norm_l2();
        assert!(error < tolerance(placement.condition, norm, 5), "{error:e}");
        // Both stop when the determinant stands still, to 1e-4 here.
        assert!((placement.condition / reference - 1.0).abs() < 5e-3, "{}", placement.condition);
    }
}

#[test]
fn bad_requests_are_named() {
    let model = plant(Draw { nx: 3, nu: 1, ny: 1, radius: 0.9, seed: 5 });
    let real = |v: f64| c64::new(v, 0.0);
    let place = |poles: &[c64]| ObserverDesign::place(&model, poles).unwrap_err();
    assert_eq!(place(&[real(0.1)]), DesignError::PoleCount { expected: 3, found: 1 });
    assert_eq!(
        place(&[real(0.1), c64::new(0.2, 0.3), c64::new(0.2, 0.3)]),
        DesignError::PoleConjugate { re: 0.2, im: 0.3 }
    );
    assert_eq!(
        place(&[real(0.1), real(0.1), real(0.2)]),
        DesignError::PoleMultiplicity { re: 0.1, im: 0.0, multiplicity: 2, rank: 1 }
    );
    assert_eq!(
        place(&[real(0.1), real(1.0), real(0.2)]),
        ModelError::Unstable { what: "a wanted observer", re: 1.0, im: 0.0 }.into()
    );
    let nan = place_poles(model.a(), model.c(), &[real(0.1), real(f64::NAN), real(0.2)]);
    assert!(matches!(nan, Err(DesignError::PoleConjugate { .. })));
}

#[test]
fn a_hidden_mode_is_named() {
    let diagonal = |values: &[f64]| {
        Mat::from_fn(values.len(), values.len(), |i, j| if i == j { values[i] } else { 0.0 })
    };
    let a = diagonal(&[0.5, 1.2, 0.7]);
    let c = mat![[1.0, 0.0, 1.0]];
    let model = StateSpace::new(a, Mat::zeros(3, 1), c, Mat::zeros(1, 1), sampled()).unwrap();
    let poles = [0.1, 0.2, 0.3].map(|v| c64::new(v, 0.0));
    for error in [
        ObserverDesign::place(&model, &poles).unwrap_err(),
        ObserverDesign::kalman(&model, 1.0, 1.0).unwrap_err(),
    ] {
        let named = matches!(error, DesignError::Unobservable { re, im, .. }
            if (re - 1.2).abs() < 1e-12 && im.abs() < 1e-12);
        assert!(named, "{error}");
    }
    // A Kalman filter needs to see only what does not die out by itself.
    let c = mat![[0.0, 1.0, 1.0]];
    let (a, b) = (model.a().to_owned(), model.b().to_owned());
    let model = StateSpace::new(a, b, c, Mat::zeros(1, 1), sampled()).unwrap();
    assert!(ObserverDesign::kalman(&model, 1.0, 1.0).is_ok());
    assert!(ObserverDesign::place(&model, &poles).is_err());
}

#[test]
fn bad_covariances_are_named() {
    let model = plant(Draw { nx: 2, nu: 1, ny: 2, radius: 0.9, seed: 5 });
    let identity = Mat::<f64>::identity(2, 2);
    let kalman = |q: &Mat<f64>, r: &Mat<f64>| {
        ObserverDesign::kalman_with(&model, q.as_ref(), r.as_ref()).unwrap_err()
    };
    let not_positive = |error| match error {
        DesignError::Model(ModelError::NotPositive { needed, .. }) => needed,
        other => panic!("{other}"),
    };
    assert_eq!(not_positive(kalman(&identity, &mat![[1.0, 1.0], [1.0, 1.0]])), "definite");
    assert_eq!(not_positive(kalman(&mat![[1.0, 0.0], [0.0, -1.0]], &identity)), "semidefinite");
    assert_eq!(not_positive(kalman(&mat![[1.0, 0.5], [0.0, 1.0]], &identity)), "semidefinite");
    assert_eq!(not_positive(ObserverDesign::kalman(&model, 1.0, 0.0).unwrap_err()), "definite");
    let small = Mat::<f64>::identity(1, 1);
    assert!(matches!(kalman(&identity, &small), DesignError::Shape(_)));
    let nan = Mat::from_fn(2, 2, |_, _| f64::NAN);
    assert!(matches!(kalman(&nan, &identity), DesignError::Model(ModelError::NonFinite { .. })));
}
