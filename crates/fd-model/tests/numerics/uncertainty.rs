//! Forms of uncertainty and random perturbations.

use faer::{Mat, mat};
use fd_model::{
    Discrete, ModelError, StateSpace,
    uncertainty::{MatrixPerturbation, Spread, Uncertainty, perturb_parameters},
};
use fd_numeric::dense::Dense;
use proptest::prelude::*;

use crate::{
    engines::engine17,
    models::{Recipe, continuous, discrete, distance_c, recipes, ts},
};

#[test]
fn a_thousand_perturbed_engines_are_stable_and_reproducible() {
    let (engine, _) = engine17("ref");
    let ten_percent = MatrixPerturbation::default();
    let mut rejected = 0;
    for seed in 0..1000 {
        let draw = ten_percent.draw(&engine, seed).unwrap();
        assert!(draw.model.is_stable().unwrap());
        rejected += draw.rejected;
        if seed % 100 == 0 {
            let again = ten_percent.draw(&engine, seed).unwrap();
            assert_eq!(again.model.a(), draw.model.a());
            assert_eq!(again.rejected, draw.rejected);
        }
    }
    println!("{rejected} unstable draws for 1000 stable ones");
}

/// Relative changes, uniform in `±fraction` and independent: the largest of 400 misses the outer
/// tenth with a probability of 0.9⁴⁰⁰ = 5e-19; mean and mean square have deviations of
/// `fraction/√3` and `fraction² √(4/45)` over 20, of which four are allowed.
fn assert_uniform(what: &str, changes: &[f64], fraction: f64) {
    assert!(400 <= changes.len());
    let count = changes.len() as f64;
    let largest = changes.iter().fold(0.0_f64, |largest, c| largest.max(c.abs()));
    // The quotient that is looked at is rounded once more than the product that made it.
    let rounding = 4.0 * f64::EPSILON;
    assert!((0.9 * fraction..=fraction + rounding).contains(&largest), "{what}: {largest}");
    let mean = changes.iter().sum::<f64>() / count;
    assert!(mean.abs() < 0.2 * fraction / 3.0_f64.sqrt(), "{what}: {mean}");
    let square = changes.iter().map(|c| c * c).sum::<f64>() / count / fraction.powi(2);
    assert!((square - 1.0 / 3.0).abs() < 0.2 * (4.0 / 45.0_f64).sqrt(), "{what}: {square}");
}

/// A stable plant without a zero, so that each entry has a relative change.
fn full_plant() -> StateSpace<Discrete> {
    let (a, b) = (mat![[0.4, 0.1], [-0.2, 0.3]], mat![[1.0, -0.5], [0.25, 2.0]]);
    let (c, d) = (mat![[1.0, 0.5], [-2.0, 0.75]], mat![[0.1, 0.2], [-0.3, 0.4]]);
    StateSpace::new(a, b, c, d, Discrete { ts: ts(1.0) }).unwrap()
}

fn matrices(model: &StateSpace<Discrete>) -> [Mat<f64>; 4] {
    [model.a(), model.b(), model.c(), model.d()].map(|m| m.to_owned())
}

/// The paper's 10 %: every entry of every matrix that is to change fills its range, in every
/// choice of matrices, and the others stay as they are.
#[test]
fn perturbations_fill_their_range_in_the_chosen_matrices_only() {
    let default = MatrixPerturbation::default();
    let paper =
        MatrixPerturbation { spread: Spread::ElementWise, fraction: 0.1, matrices: [true; 4] };
    assert_eq!(default, paper);
    let nominal = full_plant();
    for choice in 0..16_u32 {
        let chosen = std::array::from_fn(|m| choice & (1 << m) != 0);
        for fraction in [0.1, 0.02] {
            let perturbation = MatrixPerturbation { fraction, matrices: chosen, ..default };
            let mut changes = [const { Vec::new() }; 4];
            for seed in 0..100 {
                let draw = perturbation.draw(&nominal, seed).unwrap();
                for (m, (found, was)) in
                    matrices(&draw.model).iter().zip(matrices(&nominal)).enumerate()
                {
                    let entries = (0..4).map(|k| (k / 2, k % 2));
                    changes[m].extend(entries.map(|at| found[at] / was[at] - 1.0));
                    let last = &changes[m][changes[m].len() - 4..];
                    // Entries change independently of each other.
                    assert!(!chosen[m] || last.windows(2).all(|w| (w[0] - w[1]).abs() > 1e-9));
                }
            }
            for (m, changes) in changes.iter().enumerate() {
                if chosen[m] {
                    let what = format!("{} of {chosen:?}", ["A", "B", "C", "D"][m]);
                    assert_uniform(&what, changes, fraction);
                } else {
                    assert!(changes.iter().all(|change| change.abs() <= 0.0));
                }
            }
        }
    }
}

/// The size of a change within a norm is uniform up to the fraction: twice it, less one fraction,
/// is uniform on either side of zero.
#[test]
fn perturbations_within_a_norm_fill_it() {
    let nominal = full_plant();
    let norm = |m: &Mat<f64>| m.sigmas().unwrap()[0];
    for (m, what) in ["A", "B", "C", "D"].into_iter().enumerate() {
        let fraction = 0.1;
        let matrices_chosen = std::array::from_fn(|other| other == m);
        let perturbation =
            MatrixPerturbation { spread: Spread::NormBounded, fraction, matrices: matrices_chosen };
        let sizes: Vec<f64> = (0..400)
            .map(|seed| {
                let draw = perturbation.draw(&nominal, seed).unwrap();
                let (found, was) = (&matrices(&draw.model)[m], &matrices(&nominal)[m]);
                2.0 * norm(&(found - was)) / norm(was) - fraction
            })
            .collect();
        assert_uniform(what, &sizes, fraction);
    }
}

/// Each parameter by a factor of its own.
#[test]
fn perturbed_parameters_fill_their_range() {
    let nominal = [0.5, -2.0, 4.0];
    let model = |p: &[f64]| {
        let d = Discrete { ts: ts(1.0) };
        StateSpace::new(mat![[p[0]]], mat![[p[1]]], mat![[p[2]]], mat![[0.0]], d)
    };
    let mut changes = [const { Vec::new() }; 3];
    for seed in 0..400 {
        let found = perturb_parameters(&nominal, 0.1, seed, model).unwrap();
        let [a, b, c, _] = matrices(&found.draw.model).map(|m| m[(0, 0)]);
        assert_eq!(found.parameters, [a, b, c]);
        for ((changes, found), was) in changes.iter_mut().zip([a, b, c]).zip(nominal) {
            changes.push(found / was - 1.0);
        }
    }
    for (what, changes) in ["first", "second", "third"].into_iter().zip(&changes) {
        assert_uniform(what, changes, 0.1);
    }
    let [first, second, _] = &changes;
    assert!(first.iter().zip(second).all(|(a, b)| (a - b).abs() > 1e-9));
}

#[test]
fn hopeless_perturbations_give_up() {
    let model = |p: &[f64]| {
        let d = Discrete { ts: ts(1.0) };
        StateSpace::new(mat![[p[0]]], mat![[1.0]], mat![[1.0]], mat![[0.0]], d)
    };
    // Only the nominal parameter itself makes a stable model.
    let marginal = |p: &[f64]| if (p[0] - 0.5).abs() <= 0.0 { model(p) } else { model(&[2.0]) };
    let error = perturb_parameters(&[0.5], 0.1, 1, marginal).unwrap_err();
    assert_eq!(error, ModelError::NoStableDraw { draws: 1000 });
}

#[test]
fn unstable_or_senseless_requests_are_refused() {
    let d = Discrete { ts: ts(1.0) };
    let unstable = StateSpace::new(mat![[1.5]], mat![[1.0]], mat![[1.0]], mat![[0.0]], d).unwrap();
    let error = MatrixPerturbation::default().draw(&unstable, 0).unwrap_err();
    assert_eq!(error, ModelError::Unstable { what: "a perturbed nominal model", re: 1.5, im: 0.0 });
    let negative = MatrixPerturbation { fraction: -0.1, ..MatrixPerturbation::default() };
    assert!(matches!(negative.draw(&unstable, 0), Err(ModelError::OutOfRange { .. })));
    let not_a_number = MatrixPerturbation { fraction: f64::NAN, ..MatrixPerturbation::default() };
    assert!(matches!(not_a_number.draw(&unstable, 0), Err(ModelError::OutOfRange { .. })));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn forms_agree_with_their_equations(recipe in recipes(5), omega in 0.0..30.0_f64) {
        let Recipe { nu, ny, seed, .. } = recipe;
        let nominal = discrete(recipe);
        let delta = |nu, ny| discrete(Recipe { nx: 2, nu, ny, seed: seed ^ 7 });
        let h_y = discrete(Recipe { nx: 3, nu: ny, ny: 1, seed: seed ^ 9 });
        let at = |model: &StateSpace<Discrete>| model.frequency_response(omega).unwrap();
        let (g, h) = (at(&nominal), at(&h_y));
        let cases = [
            (Uncertainty::Additive(delta(nu, ny)), at(&delta(nu, ny))),
            (Uncertainty::InputMultiplicative(delta(nu, nu)), &g * at(&delta(nu, nu))),
            (Uncertainty::OutputMultiplicative(delta(ny, ny)), at(&delta(ny, ny)) * &g),
        ];
        for (uncertainty, expected) in cases {
            let plant = uncertainty.perturbed(&nominal).unwrap();
            let size = g.norm_l2() + expected.norm_l2();
            prop_assert!((at(&plant) - &g - &expected).norm_l2() < 1e-11 * size);
            let bias = uncertainty.residual_transfer(&h_y, &nominal).unwrap();
            let size = h.norm_l2() * expected.norm_l2();
            prop_assert!((at(&bias) - &h * &expected).norm_l2() < 1e-11 * size);
            let recovered = Uncertainty::between(&nominal, &plant).unwrap();
            let again = recovered.perturbed(&nominal).unwrap();
            prop_assert!(distance_c(at(&again).as_ref(), at(&plant).as_ref()) < 1e-9);
        }
    }

    #[test]
    fn draws_are_bounded_stable_and_reproducible(recipe in recipes(6), seed: u64, fraction in 0.0..0.5_f64) {
        let nominal = continuous(recipe);
        for spread in [Spread::ElementWise, Spread::NormBounded] {
            let matrices = [true, true, false, true];
            let perturbation = MatrixPerturbation { spread, fraction, matrices };
            let draw = perturbation.draw(&nominal, seed).unwrap();
            prop_assert!(draw.model.is_stable().unwrap());
            prop_assert_eq!(draw.model.c(), nominal.c());
            for (found, expected) in [(draw.model.a(), nominal.a()), (draw.model.b(), nominal.b())] {
                let norm = |m: &Mat<f64>| m.sigmas().unwrap()[0];
                let change = found - expected;
                match spread {
                    Spread::ElementWise => {
                        for j in 0..change.ncols() {
                            for i in 0..change.nrows() {
                                let limit = fraction * expected[(i, j)].abs() * (1.0 + 1e-12) + 1e-15;
                                prop_assert!(change[(i, j)].abs() <= limit);
                            }
                        }
                    }
                    Spread::NormBounded => {
                        let limit = fraction * norm(&expected.to_owned()) * (1.0 + 1e-12) + 1e-14;
                        prop_assert!(norm(&change) <= limit);
                    }
                }
            }
            let again = perturbation.draw(&nominal, seed).unwrap();
            prop_assert_eq!(again.model.a(), draw.model.a());
            prop_assert_eq!(again.rejected, draw.rejected);
        }
    }
}
