//! Forms of uncertainty and random perturbations.

use faer::{Mat, mat};
use fd_model::{
    Discrete, ModelError, StateSpace,
    uncertainty::{MatrixPerturbation, Spread, Uncertainty, perturb_parameters},
};
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
                let norm = |m: &Mat<f64>| m.singular_values().unwrap()[0];
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
