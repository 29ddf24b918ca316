//! H2 and H-infinity norms, and zeros.

use faer::{Mat, Scale, c64, mat, prelude::Solve};
use fd_model::{Continuous, Discrete, ModelError, StateSpace, TimeDomain, reduce};
use fd_numeric::dense::{Dense, DenseReal};
use proptest::prelude::*;

use crate::{
    engines::engine17,
    models::{Recipe, continuous, discrete, recipes, sigma, ts},
};

fn check_peak<D: TimeDomain>(model: &StateSpace<D>, top: f64) -> Result<(), TestCaseError> {
    let peak = model.hinf_norm(1e-6).unwrap();
    let attained = sigma(model.frequency_response(peak.omega).unwrap().as_ref());
    prop_assert!((attained - peak.norm).abs() <= 1e-12 * peak.norm);
    for k in 0..=400 {
        let omega = top * f64::from(k) / 400.0;
        let gain = sigma(model.frequency_response(omega).unwrap().as_ref());
        prop_assert!(gain <= peak.norm * (1.0 + 2e-6), "{gain} at {omega} over {peak:?}");
    }
    let hankel = model.hankel_singular_values().unwrap();
    prop_assert!(hankel[0] <= peak.norm * (1.0 + 2e-6));
    Ok(())
}

fn check_h2<D: TimeDomain>(model: &StateSpace<D>) -> Result<(), TestCaseError> {
    let forward = model.h2_norm().unwrap();
    let q = model.observability_gramian().unwrap();
    let energy: f64 = (model.b().transpose() * q * model.b()).diagonal().column_vector().sum();
    let direct = model.domain().feedthrough_h2_squared(model.d().norm_l2().powi(2));
    let backward = (energy + direct).sqrt();
    prop_assert!((forward - backward).abs() < 1e-11 * forward, "{forward} and {backward}");
    Ok(())
}

fn strictly_proper(model: &StateSpace<Continuous>) -> StateSpace<Continuous> {
    let (a, b, c) = (model.a().to_owned(), model.b().to_owned(), model.c().to_owned());
    StateSpace::new(a, b, c, Mat::zeros(model.ny(), model.nu()), Continuous).unwrap()
}

#[test]
fn narrow_peaks_are_found() {
    // Two lightly damped modes whose peaks no grid would hit.
    let (zeta, fast) = (1e-5_f64, 37.123_f64);
    let mode = |omega: f64, gain: f64| {
        let a = mat![[0.0, omega], [-omega, -2.0 * zeta * omega]];
        let (b, c) = (mat![[0.0], [omega]], mat![[gain, 0.0]]);
        StateSpace::new(a, b, c, mat![[0.0]], Continuous).unwrap()
    };
    let both = mode(1.0, 1.0).parallel(&mode(fast, 1.5)).unwrap();
    let peak = both.hinf_norm(1e-9).unwrap();
    let expected = 1.5 / (2.0 * zeta * (1.0 - zeta * zeta).sqrt());
    // The other mode adds about 1/fast² to a peak of 75000.
    assert!((peak.norm / expected - 1.0).abs() < 1e-7, "{peak:?} is not {expected}");
    assert!((peak.omega / fast - 1.0).abs() < 1e-7);
    // The norm does not depend on Tustin's map.
    let sampled = both.sample_tustin(ts(0.01)).unwrap().hinf_norm(1e-9).unwrap();
    assert!((sampled.norm / peak.norm - 1.0).abs() < 1e-6, "{sampled:?}");
}

#[test]
fn norms_of_special_models_are_exact() {
    let gain = StateSpace::gain(mat![[3.0, 4.0]], Continuous).unwrap();
    assert!((gain.hinf_norm(1e-6).unwrap().norm - 5.0).abs() < 1e-15);
    assert!(gain.h2_norm().unwrap().is_infinite());
    let gain = StateSpace::gain(mat![[3.0, 4.0]], Discrete { ts: ts(0.1) }).unwrap();
    assert!((gain.h2_norm().unwrap() - 5.0).abs() < 1e-15);

    // (s − 1)/(s + 1) has gain one everywhere.
    let all_pass =
        StateSpace::new(mat![[-1.0]], mat![[-2.0]], mat![[1.0]], mat![[1.0]], Continuous).unwrap();
    assert!((all_pass.hinf_norm(1e-8).unwrap().norm - 1.0).abs() < 1e-14);

    // A model that nothing drives.
    let silent =
        StateSpace::new(mat![[-1.0]], mat![[0.0]], mat![[1.0]], mat![[0.0]], Continuous).unwrap();
    assert!(silent.hinf_norm(1e-6).unwrap().norm <= 0.0);
    assert!(silent.h2_norm().unwrap() <= 0.0);
}

#[test]
fn norms_refuse_what_they_cannot_do() {
    let model =
        StateSpace::new(mat![[1.0]], mat![[1.0]], mat![[1.0]], mat![[0.0]], Continuous).unwrap();
    let error = model.hinf_norm(1e-6).unwrap_err();
    assert_eq!(error, ModelError::Unstable { what: "the H-infinity norm", re: 1.0, im: 0.0 });
    assert!(matches!(model.h2_norm(), Err(ModelError::Unstable { .. })));
    assert!(matches!(model.hinf_norm(0.0), Err(ModelError::OutOfRange { .. })));
}

#[test]
fn reduction_errors_of_the_engine_stay_below_the_bound_at_their_peak() {
    let (engine, _) = engine17("ref");
    let sampled = engine.sample_zoh(ts(0.02)).unwrap();
    for order in [1, 3, 5, 8, 12] {
        check_reduction(&engine, order).unwrap();
        check_reduction(&sampled, order).unwrap();
    }
}

fn check_reduction<D: TimeDomain>(
    model: &StateSpace<D>,
    order: usize,
) -> Result<(), TestCaseError> {
    let hankel = model.hankel_singular_values().unwrap();
    prop_assume!(hankel.get(order.max(1) - 1).is_some_and(|h| *h > 1e-9 * hankel[0]));
    let tolerance = 1e-4;
    for reduction in [
        reduce::balanced_truncation(model, order).unwrap(),
        reduce::balanced_residualisation(model, order).unwrap(),
    ] {
        let error = model.difference(&reduction.model).unwrap().hinf_norm(tolerance).unwrap().norm;
        // Rounding in the realisation of the reduced model, relative to the largest value.
        let bound = reduction.error_bound + 1e-11 * hankel[0];
        prop_assert!(error <= bound, "order {order}: {error:e} over {bound:e}");
        let next = hankel.get(order).copied().unwrap_or(0.0);
        prop_assert!(
            next <= error * (1.0 + tolerance) + 1e-11 * hankel[0],
            "Hankel value {next:e} over the error"
        );
    }
    Ok(())
}

/// Sorts by real, then imaginary part, and compares relative to the largest.
fn same_points(x: &[c64], y: &[c64], tolerance: f64) -> bool {
    let size = x.iter().chain(y).map(|p| p.norm()).fold(1e-300, f64::max);
    x.len() == y.len()
        && x.iter().all(|p| y.iter().any(|q| (p - q).norm() < tolerance * size))
        && y.iter().all(|p| x.iter().any(|q| (p - q).norm() < tolerance * size))
}

#[test]
fn zeros_of_known_models_are_found() {
    // (s + 1)(s + 2)/((s + 3)(s + 4)(s + 5)) in companion form.
    let a = mat![[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-60.0, -47.0, -12.0]];
    let (b, c) = (mat![[0.0], [0.0], [1.0]], mat![[2.0, 3.0, 1.0]]);
    let model = StateSpace::new(a, b, c, mat![[0.0]], Continuous).unwrap();
    let expected = [c64::new(-1.0, 0.0), c64::new(-2.0, 0.0)];
    assert!(same_points(&model.zeros().unwrap(), &expected, 1e-13));

    // A chain of integrators has none.
    let a = mat![[0.0, 1.0], [0.0, 0.0]];
    let (b, c) = (mat![[0.0], [1.0]], mat![[1.0, 0.0]]);
    let chain = StateSpace::new(a, b, c, mat![[0.0]], Continuous).unwrap();
    assert!(chain.zeros().unwrap().is_empty());

    // One input, two outputs with a common zero at −3, and none in common after a change.
    let a = mat![[-1.0, 0.0], [0.0, -2.0]];
    let b = mat![[1.0], [1.0]];
    let shared = mat![[2.0, -1.0], [4.0, -2.0]];
    let model =
        |c: Mat<f64>| StateSpace::new(a.clone(), b.clone(), c, Mat::zeros(2, 1), Continuous);
    assert!(same_points(&model(shared).unwrap().zeros().unwrap(), &[c64::new(-3.0, 0.0)], 1e-13));
    assert!(model(mat![[2.0, -1.0], [4.0, -2.5]]).unwrap().zeros().unwrap().is_empty());
}

#[test]
fn zeros_at_sizes_where_a_qz_algorithm_failed() {
    for nx in [76, 100] {
        let model = continuous(Recipe { nx, nu: 2, ny: 2, seed: 5 });
        let d = model.d() + Scale(3.0) * Mat::<f64>::identity(2, 2);
        check_inverse(&model, d, 1e-8).unwrap();
    }
}

/// With `D` invertible, the zeros are the eigenvalues of `A − B D⁻¹ C`.
fn check_inverse(
    model: &StateSpace<Continuous>,
    d: Mat<f64>,
    tolerance: f64,
) -> Result<(), TestCaseError> {
    let (a, b, c) = (model.a().to_owned(), model.b().to_owned(), model.c().to_owned());
    let inverse = &a - &b * d.lu().solve(&c);
    let expected = inverse.modes().unwrap();
    let zeros = StateSpace::new(a, b, c, d, Continuous).unwrap().zeros().unwrap();
    prop_assert!(same_points(&zeros, &expected, tolerance), "{zeros:?}\n{expected:?}");
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn peak_gain_is_attained_and_nowhere_exceeded(recipe in recipes(10)) {
        check_peak(&continuous(recipe), 20.0)?;
        check_peak(&strictly_proper(&continuous(recipe)), 20.0)?;
        check_peak(&discrete(recipe), 31.4)?;
    }

    #[test]
    fn h2_norm_agrees_from_both_gramians(recipe in recipes(12)) {
        check_h2(&strictly_proper(&continuous(recipe)))?;
        check_h2(&discrete(recipe))?;
    }

    #[test]
    fn reduction_error_lies_between_the_next_hankel_value_and_the_bound(recipe in recipes(9), order in 0..9_usize) {
        let order = order.min(recipe.nx);
        check_reduction(&continuous(recipe), order)?;
        check_reduction(&discrete(recipe), order)?;
    }

    #[test]
    fn zeros_are_the_poles_of_the_inverse(recipe in recipes(10)) {
        let model = continuous(Recipe { ny: recipe.nu, ..recipe });
        let d = model.d() + Scale(2.5) * Mat::<f64>::identity(recipe.nu, recipe.nu);
        // Eigenvalues of random matrices of this size are conditioned up to about 1e4.
        check_inverse(&model, d, 1e-9)?;
    }

    #[test]
    fn transfer_matrix_loses_rank_at_its_zeros(recipe in recipes(7)) {
        let model = strictly_proper(&continuous(Recipe { nu: 2, ny: 2, ..recipe }));
        let zeros = model.zeros().unwrap();
        // Generic models with two inputs and outputs and CB of full rank.
        prop_assert_eq!(zeros.len(), recipe.nx.saturating_sub(2));
        for zero in zeros {
            let n = recipe.nx;
            let system = Mat::from_fn(n + 2, n + 2, |i, j| {
                let entry = match (i < n, j < n) {
                    (true, true) => model.a()[(i, j)],
                    (true, false) => model.b()[(i, j - n)],
                    (false, true) => model.c()[(i - n, j)],
                    (false, false) => 0.0,
                };
                c64::new(entry, 0.0) - if i == j && i < n { zero } else { c64::new(0.0, 0.0) }
            });
            let values = system.sigmas().unwrap();
            prop_assert!(values[n + 1] < 1e-9 * values[0], "{zero} is no zero: {:e}", values[n + 1]);
        }
    }
}
