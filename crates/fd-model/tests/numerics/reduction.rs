//! Gramians, balancing and reduction.

use faer::{Mat, mat};
use fd_model::{Continuous, Discrete, ModelError, StateSpace, TimeDomain, reduce};
use proptest::prelude::*;

use crate::{
    engines::{engine17, f100},
    models::{continuous, discrete, distance, recipes, sigma, ts},
};

/// Largest gain of the error over a grid of frequencies.
fn gridded_error<D: TimeDomain>(full: &StateSpace<D>, reduced: &StateSpace<D>, top: f64) -> f64 {
    let error = full.difference(reduced).unwrap();
    (0..=200)
        .map(|k| top * 1e-6_f64.powf(1.0 - f64::from(k) / 200.0))
        .chain([0.0])
        .map(|omega| sigma(error.frequency_response(omega).unwrap().as_ref()))
        .fold(0.0, f64::max)
}

fn check_balanced<D: TimeDomain>(model: &StateSpace<D>) -> Result<(), TestCaseError> {
    let n = model.nx();
    let hankel = model.hankel_singular_values().unwrap();
    prop_assume!(hankel[n - 1] > 1e-7 * hankel[0]);
    let balanced = reduce::balanced_truncation(model, n).unwrap().model;
    let diagonal = Mat::from_fn(n, n, |i, j| if i == j { hankel[i] } else { 0.0 });
    let p = balanced.controllability_gramian().unwrap();
    let q = balanced.observability_gramian().unwrap();
    // The transformation has the condition σ₁/σₙ ≤ 1e7.
    prop_assert!((&p - &diagonal).norm_max() < 1e-8 * hankel[0], "P of the balanced model");
    prop_assert!((&q - &diagonal).norm_max() < 1e-8 * hankel[0], "Q of the balanced model");
    Ok(())
}

fn check_bound<D: TimeDomain>(
    model: &StateSpace<D>,
    order: usize,
    top: f64,
) -> Result<(), TestCaseError> {
    let hankel = model.hankel_singular_values().unwrap();
    prop_assume!(hankel.get(order.max(1) - 1).is_some_and(|h| *h > 1e-10 * hankel[0]));
    let truncated = reduce::balanced_truncation(model, order).unwrap();
    let residualised = reduce::balanced_residualisation(model, order).unwrap();
    for reduction in [&truncated, &residualised] {
        let error = gridded_error(model, &reduction.model, top);
        let bound = reduction.error_bound * (1.0 + 1e-9) + 1e-11 * hankel[0];
        prop_assert!(error <= bound, "error {error:e} over the bound {bound:e}");
    }
    let (full, reduced) = (model.dc_gain().unwrap(), residualised.model.dc_gain().unwrap());
    prop_assert!((&full - &reduced).norm_l2() <= 1e-13 * (full.norm_l2() + hankel[0]));
    Ok(())
}

#[test]
fn engines_reduce_to_five_states_within_the_bound() {
    let models = [engine17("ref"), engine17("idle"), f100()];
    for (model, _) in models {
        let truncated = reduce::balanced_truncation(&model, 5).unwrap();
        let residualised = reduce::balanced_residualisation(&model, 5).unwrap();
        for reduction in [&truncated, &residualised] {
            let error = gridded_error(&model, &reduction.model, 1e4);
            println!("error {error:.4e}, bound {:.4e}", reduction.error_bound);
            assert!(error <= reduction.error_bound && error > 0.01 * reduction.error_bound);
        }
        let (full, reduced) = (model.dc_gain().unwrap(), residualised.model.dc_gain().unwrap());
        assert!(distance(full.as_ref(), reduced.as_ref()) < 1e-14);
        let spools = reduce::residualise_onto(&model, &[0, 1]).unwrap();
        assert!(distance(full.as_ref(), spools.dc_gain().unwrap().as_ref()) < 1e-11);
    }
}

#[test]
fn uncontrollable_states_are_not_promised() {
    let a = mat![[-1.0, 0.0], [0.0, -2.0]];
    let (b, c) = (mat![[1.0], [0.0]], mat![[1.0, 1.0]]);
    let model = StateSpace::new(a, b, c, mat![[0.0]], Continuous).unwrap();
    let error = reduce::balanced_truncation(&model, 2).unwrap_err();
    let what = "states are both controllable and observable";
    assert_eq!(error, ModelError::Order { requested: 2, available: 1, what });
    let minimal = reduce::balanced_truncation(&model, 1).unwrap();
    assert!((minimal.model.a()[(0, 0)] + 1.0).abs() < 1e-15 && minimal.error_bound < 1e-15);
}

#[test]
fn defective_and_repeated_eigenvalues_are_no_special_case() {
    for off in [0.0, 1.0] {
        let a = mat![[-1.0, off, 0.0], [0.0, -1.0, off], [0.0, 0.0, -1.0]];
        let (b, c) = (mat![[0.5], [0.25], [1.0]], mat![[1.0, 0.3, 0.1]]);
        let model = StateSpace::new(a, b, c, mat![[0.0]], Continuous).unwrap();
        let p = model.controllability_gramian().unwrap();
        let residual =
            model.a() * &p + &p * model.a().transpose() + model.b() * model.b().transpose();
        assert!(residual.norm_l2() < 1e-14);
        assert!(model.hankel_singular_values().unwrap()[0] > 0.0);
    }
}

#[test]
fn unstable_models_are_refused_with_their_worst_eigenvalue() {
    let a = mat![[-1.0, 0.0], [0.0, 0.5]];
    let (b, c) = (mat![[1.0], [1.0]], mat![[1.0, 1.0]]);
    let model = StateSpace::new(a, b, c, mat![[0.0]], Continuous).unwrap();
    let error = reduce::balanced_truncation(&model, 1).unwrap_err();
    assert_eq!(error, ModelError::Unstable { what: "balancing", re: 0.5, im: 0.0 });
}

/// The factors of the gramians exist here, and say nothing of the mode that nobody sees.
#[test]
fn hidden_unstable_modes_are_refused() {
    fn check<D: TimeDomain>(unstable: f64, stable: f64, domain: D) {
        let a = mat![[stable, 0.0], [0.0, unstable]];
        for (b, c) in [([1.0, 0.0], [1.0, 0.0]), ([0.0, 0.0], [1.0, 0.0])] {
            let (b, c) = (mat![[b[0]], [b[1]]], mat![[c[0], c[1]]]);
            let model = StateSpace::new(a.clone(), b, c, mat![[0.0]], domain).unwrap();
            let error = model.hankel_singular_values().unwrap_err();
            let what = "the Hankel singular values";
            assert_eq!(error, ModelError::Unstable { what, re: unstable, im: 0.0 });
        }
    }
    check(0.5, -1.0, Continuous);
    check(1.5, 0.5, Discrete { ts: ts(0.1) });
    // Slow growth takes long to show.
    check(1.0 + 1e-9, 0.5, Discrete { ts: ts(0.1) });
}

#[test]
fn nothing_comes_of_no_input() {
    let (a, b, c) = (mat![[-1.0, 3.0], [0.0, -2.0]], Mat::zeros(2, 1), mat![[1.0, 1.0]]);
    let model = StateSpace::new(a, b, c, mat![[0.0]], Continuous).unwrap();
    let values = model.hankel_singular_values().unwrap();
    assert!(values.len() == 2 && values.iter().all(|value| value.abs() <= 0.0), "{values:?}");
}

#[test]
fn chosen_states_must_exist_and_be_different() {
    let model =
        StateSpace::new(mat![[-1.0]], mat![[1.0]], mat![[1.0]], mat![[0.0]], Continuous).unwrap();
    let error = reduce::residualise_onto(&model, &[1]).unwrap_err();
    assert_eq!(error, ModelError::StateIndex { index: 1, states: 1, why: "does not exist" });
    let error = reduce::residualise_onto(&model, &[0, 0]).unwrap_err();
    assert_eq!(error, ModelError::StateIndex { index: 0, states: 1, why: "is listed twice" });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn balanced_gramians_are_equal_and_diagonal(recipe in recipes(8)) {
        check_balanced(&continuous(recipe))?;
        check_balanced(&discrete(recipe))?;
    }

    #[test]
    fn reduction_errors_stay_below_their_bound(recipe in recipes(10), order in 0..10_usize) {
        let order = order.min(recipe.nx);
        check_bound(&continuous(recipe), order, 1e3)?;
        check_bound(&discrete(recipe), order, 31.4)?;
    }

    #[test]
    fn gramians_solve_their_equations(recipe in recipes(15)) {
        let model = continuous(recipe);
        let (a, b, c) = (model.a(), model.b(), model.c());
        let p = model.controllability_gramian().unwrap();
        let q = model.observability_gramian().unwrap();
        let bb = b * b.transpose();
        let cc = c.transpose() * c;
        let left = (a * &p + &p * a.transpose() + &bb).norm_l2() / (a.norm_l2() * p.norm_l2());
        let right = (a.transpose() * &q + &q * a + &cc).norm_l2() / (a.norm_l2() * q.norm_l2());
        // n ε times the condition of the Cayley transform, below 1e3 for these models.
        prop_assert!(left.max(right) < 1e-12, "{left:e} {right:e}");
    }
}
