//! Riccati equations: closed forms, residuals, stability, bad input.

use faer::{Mat, mat};
use fd_model::{ModelError, riccati};
use fd_numeric::dense::DenseReal;
use proptest::prelude::*;

use crate::models::{distance, random, recipes, rng};

#[test]
fn scalar_riccati_equation_has_its_closed_form() {
    for (a, b, q, r) in [(1.0, 1.0, 1.0, 1.0), (0.5, 2.0, 3.0, 0.1), (1.7, 0.3, 1e-3, 40.0)] {
        // p = a²p − a²p²b²/(r + b²p) + q, a quadratic in p.
        let (half, square): (f64, f64) = (0.5 * (r - a * a * r - q * b * b), q * r * b * b);
        let p = ((half * half + square).sqrt() - half) / (b * b);
        let (ma, mb, mq, mr) = (mat![[a]], mat![[b]], mat![[q]], mat![[r]]);
        let found = riccati::discrete_regulator(ma.as_ref(), mb.as_ref(), mq.as_ref(), mr.as_ref())
            .unwrap();
        assert!((found.p[(0, 0)] - p).abs() < 1e-13 * p, "{} is not {p}", found.p[(0, 0)]);
        assert!((found.gain[(0, 0)] - a * b * p / (r + b * b * p)).abs() < 1e-13);
    }
}

#[test]
fn unreachable_unstable_modes_cannot_be_stabilised() {
    let a = mat![[2.0, 0.0], [0.0, 0.5]];
    let b = mat![[0.0], [1.0]];
    let q = Mat::<f64>::identity(2, 2);
    let error =
        riccati::discrete_regulator(a.as_ref(), b.as_ref(), q.as_ref(), mat![[1.0]].as_ref())
            .unwrap_err();
    assert!(
        matches!(error, ModelError::NotStabilisable { .. } | ModelError::NoConvergence { .. }),
        "{error}"
    );
}

/// `p = a²p / (1 + b²p/r)` has the solutions 0 and `r (a² − 1) / b²`; the second stabilises, and
/// puts the closed loop at `1/a`.
#[test]
fn unstable_modes_without_a_weight_are_mirrored() {
    let none = mat![[0.0]];
    for (a, b, r) in [(1.25, 1.0, 1.0), (-3.0, 0.2, 5.0), (1.0 + 1e-5, 2.0, 0.1)] {
        let (ma, mb, mr) = (mat![[a]], mat![[b]], mat![[r]]);
        let filter = riccati::discrete_filter(ma.as_ref(), mb.as_ref(), none.as_ref(), mr.as_ref());
        let filter = filter.unwrap();
        let p: f64 = r * (a * a - 1.0) / (b * b);
        // The margin of the loop amplifies rounding.
        let tolerance = 16.0 * f64::EPSILON / (1.0 - 1.0 / f64::abs(a));
        assert!((filter.p[(0, 0)] / p - 1.0).abs() < tolerance, "{} {p}", filter.p[(0, 0)]);
        assert!((a - filter.gain[(0, 0)] * b - 1.0 / a).abs() < tolerance);
    }
    // A mode on the circle stays there; a stable one needs nothing.
    let (one, half) = (mat![[1.0]], mat![[0.5]]);
    let regulator = |a: &Mat<f64>| {
        riccati::discrete_regulator(a.as_ref(), one.as_ref(), none.as_ref(), one.as_ref())
    };
    let what = "the discrete regulator";
    assert_eq!(
        regulator(&one).unwrap_err(),
        ModelError::NotStabilisable { what, re: 1.0, im: 0.0 }
    );
    assert!(regulator(&half).unwrap().p[(0, 0)].abs() <= 0.0);
}

#[test]
fn indefinite_weights_are_rejected() {
    let one = mat![[1.0]];
    let minus = mat![[-1.0]];
    let regulator = |q, r| riccati::discrete_regulator(one.as_ref(), one.as_ref(), q, r);
    let error = regulator(minus.as_ref(), one.as_ref()).unwrap_err();
    assert_eq!(error, ModelError::NotPositive { role: "state weight Q", needed: "semidefinite" });
    let error = regulator(one.as_ref(), mat![[0.0]].as_ref()).unwrap_err();
    assert_eq!(error, ModelError::NotPositive { role: "input weight R", needed: "definite" });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// The closed loop has the stable eigenvalues of `A` and the inverses of the others.
    #[test]
    fn filters_without_process_noise_mirror_what_is_unstable(recipe in recipes(8)) {
        let mut rng = rng(recipe.seed);
        let (n, p) = (recipe.nx, recipe.ny);
        let a = random(n, n, &mut rng);
        let c = random(p, n, &mut rng);
        let poles = a.modes().unwrap();
        prop_assume!(poles.iter().all(|z| (z.norm() - 1.0).abs() > 0.05));
        let (none, r) = (Mat::<f64>::zeros(n, n), Mat::<f64>::identity(p, p));
        let filter =
            riccati::discrete_filter(a.as_ref(), c.as_ref(), none.as_ref(), r.as_ref()).unwrap();
        let closed = (&a - &filter.gain * &c).modes().unwrap();
        // Coefficients of polynomials are smooth where eigenvalues are not: compare the sums of
        // powers. A relative error e of P moves the closed loop by up to e |P| |C|^2 |A - K C|, and
        // nearly undetectable modes make P and K large: one output of seven states (seed
        // 682354151116548284) has |P| = 1.3e7, K = 758 and an error of 1.5e-6, 2e-9 of the gain.
        let tolerance = 1e-6 * (1.0 + filter.gain.norm_max());
        let mirrored = |z: &faer::c64| if z.norm() < 1.0 { *z } else { z.conj().inv() };
        for power in 1..=3 {
            let found: f64 = closed.iter().map(|z| z.powi(power).re).sum();
            let expected: f64 = poles.iter().map(|z| mirrored(z).powi(power).re).sum();
            prop_assert!((found - expected).abs() < tolerance, "{found} {expected}");
        }
    }

    #[test]
    fn regulator_solves_its_equation_and_stabilises(recipe in recipes(12), scale in -3.0..3.0_f64) {
        let mut rng = rng(recipe.seed);
        let (n, m) = (recipe.nx, recipe.nu);
        let a = random(n, n, &mut rng);
        let b = random(n, m, &mut rng);
        let root = random(n, n, &mut rng);
        let q = &root * root.transpose();
        let r = faer::Scale(scale.exp()) * Mat::<f64>::identity(m, m);
        let found =
            riccati::discrete_regulator(a.as_ref(), b.as_ref(), q.as_ref(), r.as_ref()).unwrap();
        let p = &found.p;
        prop_assert!(distance(p.as_ref(), p.transpose()) <= 0.0, "P must be symmetric");
        let lowest = p.symmetric_eigenvalues().unwrap()[0];
        prop_assert!(lowest >= -1e-12 * p.norm_l2());

        let closed = &a - &b * &found.gain;
        let radius = closed.modes().unwrap().iter().fold(0.0_f64, |m, z| m.max(z.norm()));
        prop_assert!(radius < 1.0, "closed loop has radius {radius}");

        let residual = a.transpose() * p * &closed + &q - p;
        // n ε ‖A‖ ‖P‖ ‖A − BK‖ for the products that the residual goes through.
        let size = a.norm_l2() * p.norm_l2() * closed.norm_l2() + p.norm_l2();
        let unit = n as f64 * f64::EPSILON * size;
        prop_assert!(residual.norm_l2() < 2.0 * unit, "{:e}", residual.norm_l2() / unit);
    }
}
