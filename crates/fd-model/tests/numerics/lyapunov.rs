//! Lyapunov and Sylvester equations: residuals, edge cases, size.

use faer::{Mat, mat};
use fd_model::{ModelError, lyapunov};
use proptest::prelude::*;

use crate::models::{Recipe, continuous, discrete, distance, random, recipes, rng};

#[test]
fn unstable_equations_name_the_worst_eigenvalue() {
    let q = Mat::<f64>::identity(2, 2);
    let a = mat![[0.5, 0.0], [0.0, -1.25]];
    let error = lyapunov::discrete(a.as_ref(), q.as_ref()).unwrap_err();
    let what = "the discrete Lyapunov equation";
    assert_eq!(error, ModelError::Unstable { what, re: -1.25, im: 0.0 });
    let error = lyapunov::continuous(a.as_ref(), q.as_ref()).unwrap_err();
    let what = "the continuous Lyapunov equation";
    assert_eq!(error, ModelError::Unstable { what, re: 0.5, im: 0.0 });
}

#[test]
fn opposite_eigenvalues_have_no_unique_sylvester_solution() {
    let (a, b) = (mat![[1.0, 2.0], [0.0, 3.0]], mat![[-3.0]]);
    let error =
        lyapunov::sylvester(a.as_ref(), b.as_ref(), mat![[1.0], [1.0]].as_ref()).unwrap_err();
    assert_eq!(error, ModelError::Singular { role: "the Sylvester operator X ↦ AX + XB" });
}

#[test]
fn not_a_number_is_found_where_it_is() {
    let a = mat![[-1.0, 0.0], [f64::NAN, -1.0]];
    let error = lyapunov::continuous(a.as_ref(), Mat::identity(2, 2).as_ref()).unwrap_err();
    let expected = "state matrix A[1, 0] must be finite, got NaN";
    assert_eq!(error.to_string(), expected);
}

#[test]
fn empty_equations_have_empty_solutions() {
    let none = Mat::<f64>::zeros(0, 0);
    assert_eq!(lyapunov::continuous(none.as_ref(), none.as_ref()).unwrap().nrows(), 0);
    assert_eq!(lyapunov::discrete(none.as_ref(), none.as_ref()).unwrap().nrows(), 0);
}

#[test]
fn defective_matrices_are_no_special_case() {
    // Jordan block: X from the closed form of the covariance of a double lag.
    let a = mat![[-1.0, 1.0], [0.0, -1.0]];
    let q = mat![[0.0, 0.0], [0.0, 2.0]];
    let x = lyapunov::continuous(a.as_ref(), q.as_ref()).unwrap();
    assert!(distance(x.as_ref(), mat![[0.5, 0.5], [0.5, 1.0]].as_ref()) < 1e-15);
}

#[test]
fn hundreds_of_states_keep_the_residual_at_rounding() {
    let n = 200;
    let recipe = Recipe { nx: n, nu: 3, ny: 3, seed: 11 };
    check_continuous(recipe, 10.0).unwrap();
    check_discrete(recipe, 10.0).unwrap();
}

/// A chain of lags with rates from 1e-4 to 1e4, each driven by the one before, in units that
/// balancing cannot make alike.
#[test]
fn stiff_equations_keep_the_residual_at_rounding() {
    let n = 9;
    let rate = |i: usize| 10_f64.powi(i32::try_from(i).unwrap() - 4);
    let a = Mat::from_fn(n, n, |i, j| match i.checked_sub(j) {
        Some(0) => -rate(i),
        Some(1) => rate(j).sqrt(),
        _ => 0.0,
    });
    let q = Mat::<f64>::identity(n, n);
    let x = lyapunov::continuous(a.as_ref(), q.as_ref()).unwrap();
    let residual = (&a * &x + &x * a.transpose() + &q).norm_l2();
    let unit = n as f64 * f64::EPSILON * (a.norm_l2() * x.norm_l2() + q.norm_l2());
    assert!(residual <= unit, "{:e} units", residual / unit);
    // The slowest lag is driven by its noise alone. The residual promises its variance to
    // ε ‖A‖ / (2 rate) = 1e-8 only.
    assert!((x[(0, 0)] * 2.0 * rate(0) - 1.0).abs() < 1e-10, "{}", x[(0, 0)]);
}

/// `‖residual‖ ≤ factor · n ε (‖A‖ ‖X‖ + ‖Q‖)`.
fn check_continuous(recipe: Recipe, factor: f64) -> Result<(), TestCaseError> {
    let model = continuous(recipe);
    let (a, q) = (model.a(), model.b() * model.b().transpose());
    let x = lyapunov::continuous(a, q.as_ref()).unwrap();
    let residual = (a * &x + &x * a.transpose() + &q).norm_l2();
    let unit = recipe.nx as f64 * f64::EPSILON * (a.norm_l2() * x.norm_l2() + q.norm_l2());
    prop_assert!(residual <= factor * unit, "{:e} units", residual / unit);
    Ok(())
}

/// `‖residual‖ ≤ factor · n ε (‖A‖² ‖X‖ + ‖Q‖)`.
fn check_discrete(recipe: Recipe, factor: f64) -> Result<(), TestCaseError> {
    let model = discrete(recipe);
    let (a, q) = (model.a(), model.b() * model.b().transpose());
    let x = lyapunov::discrete(a, q.as_ref()).unwrap();
    let residual = (a * &x * a.transpose() - &x + &q).norm_l2();
    let size = a.norm_l2().powi(2) * x.norm_l2() + q.norm_l2();
    let unit = recipe.nx as f64 * f64::EPSILON * size;
    prop_assert!(residual <= factor * unit, "{:e} units", residual / unit);
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn residuals_are_at_rounding(recipe in recipes(20)) {
        // One unit for each of the handful of products that a residual goes through.
        check_continuous(recipe, 4.0)?;
        check_discrete(recipe, 4.0)?;
    }

    #[test]
    fn sylvester_equation_is_solved(recipe in recipes(12), m in 1..9_usize) {
        let mut rng = rng(recipe.seed);
        let n = recipe.nx;
        let a = random(n, n, &mut rng) + faer::Scale(3.0 * (n as f64).sqrt()) * Mat::<f64>::identity(n, n);
        let (b, expected) = (random(m, m, &mut rng) + Mat::<f64>::identity(m, m), random(n, m, &mut rng));
        let c = &a * &expected + &expected * &b;
        let x = lyapunov::sylvester(a.as_ref(), b.as_ref(), c.as_ref()).unwrap();
        let residual = &a * &x + &x * &b - &c;
        let size = (a.norm_l2() + b.norm_l2()) * x.norm_l2();
        prop_assert!(residual.norm_l2() < 4.0 * (n + m) as f64 * f64::EPSILON * size);
    }
}
