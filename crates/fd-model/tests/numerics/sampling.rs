//! Sampling and connection of models.

use faer::{Mat, mat};
use fd_model::{Continuous, Discrete, ModelError, StateSpace};
use proptest::prelude::*;

use crate::models::{Recipe, continuous, discrete, distance, distance_c, recipes, ts};

#[test]
fn double_integrator_is_sampled_exactly() {
    let a = mat![[0.0, 1.0], [0.0, 0.0]];
    let (b, c) = (mat![[0.0], [1.0]], mat![[1.0, 0.0]]);
    let model = StateSpace::new(a, b, c, mat![[0.0]], Continuous).unwrap();
    let sampled = model.sample_zoh(ts(0.5)).unwrap();
    assert!(distance(sampled.a(), mat![[1.0, 0.5], [0.0, 1.0]].as_ref()) < 1e-15);
    assert!(distance(sampled.b(), mat![[0.125], [0.5]].as_ref()) < 1e-15);
}

#[test]
fn static_gain_survives_everything() {
    let gain = StateSpace::gain(mat![[2.0, 1.0]], Continuous).unwrap();
    assert_eq!(gain.hankel_singular_values().unwrap(), Vec::<f64>::new());
    assert_eq!(gain.controllability_gramian().unwrap().nrows(), 0);
    for sampled in [gain.sample_zoh(ts(1.0)).unwrap(), gain.sample_tustin(ts(1.0)).unwrap()] {
        assert_eq!(sampled.d(), mat![[2.0, 1.0]]);
        assert_eq!(sampled.dc_gain().unwrap(), mat![[2.0, 1.0]]);
        assert_eq!(sampled.undo_tustin().unwrap().d(), mat![[2.0, 1.0]]);
    }
}

#[test]
fn different_sample_times_cannot_be_connected() {
    let model = |seconds| StateSpace::gain(mat![[1.0]], Discrete { ts: ts(seconds) }).unwrap();
    let error = model(0.1).series(&model(0.2)).unwrap_err();
    assert_eq!(error, ModelError::SampleTimeMismatch { expected: 0.1, found: 0.2 });
}

#[test]
fn ill_posed_loop_is_an_error() {
    let model = StateSpace::gain(mat![[-1.0]], Continuous).unwrap();
    let unit = StateSpace::gain(mat![[1.0]], Continuous).unwrap();
    let error = model.feedback(&unit).unwrap_err();
    assert_eq!(error, ModelError::Singular { role: "the algebraic loop I + D₁D₂" });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn sampling_composes(recipe in recipes(12), h in 0.01..2.0_f64) {
        let model = continuous(recipe);
        let (once, twice) = (model.sample_zoh(ts(h)).unwrap(), model.sample_zoh(ts(2.0 * h)).unwrap());
        // n ε ‖Ah‖ for either side; transient growth adds a digit or two.
        let tolerance = 1e-12;
        prop_assert!(distance(twice.a(), (once.a() * once.a()).as_ref()) < tolerance);
        prop_assert!(distance(twice.b(), (once.a() * once.b() + once.b()).as_ref()) < tolerance);
    }

    #[test]
    fn hold_and_tustin_keep_the_steady_state(recipe in recipes(12), h in 0.01..2.0_f64) {
        let model = continuous(recipe);
        let expected = model.dc_gain().unwrap();
        let zoh = model.sample_zoh(ts(h)).unwrap().dc_gain().unwrap();
        let tustin = model.sample_tustin(ts(h)).unwrap().dc_gain().unwrap();
        // 1 − e^{−0.1 h} ≥ 1e-3 loses up to three digits.
        prop_assert!(distance(zoh.as_ref(), expected.as_ref()) < 1e-10);
        prop_assert!(distance(tustin.as_ref(), expected.as_ref()) < 1e-10);
    }

    #[test]
    fn tustin_keeps_stability_both_ways(recipe in recipes(12), h in 0.01..2.0_f64, shift in -1.0..1.0_f64) {
        let model = continuous(recipe);
        let n = recipe.nx;
        let a = model.a() + faer::Scale(shift) * Mat::<f64>::identity(n, n);
        let model = StateSpace::new(a, model.b().to_owned(), model.c().to_owned(), model.d().to_owned(), Continuous).unwrap();
        // A pole at 2/h maps to infinity, and one on the axis could fall to either side.
        let poles = model.poles().unwrap();
        prop_assume!(poles.iter().all(|p| (p - 2.0 / h).norm() > 1e-3 && p.re.abs() > 1e-9));
        let sampled = model.sample_tustin(ts(h)).unwrap();
        prop_assert_eq!(sampled.is_stable().unwrap(), model.is_stable().unwrap());
        let back = sampled.undo_tustin().unwrap();
        prop_assert!(distance(back.a(), model.a()) < 1e-9);
        let omega = 0.7;
        let bent = 2.0 / h * (omega * h / 2.0_f64).atan();
        let (x, y) = (model.frequency_response(omega).unwrap(), sampled.frequency_response(bent).unwrap());
        prop_assert!(distance_c(x.as_ref(), y.as_ref()) < 1e-9);
    }

    #[test]
    fn connections_follow_the_algebra_of_responses(recipe in recipes(6), omega in 0.0..20.0_f64) {
        let Recipe { nu, ny, seed, .. } = recipe;
        let p = discrete(recipe);
        let same = discrete(Recipe { seed: seed ^ 1, ..recipe });
        let back = discrete(Recipe { nx: 3, nu: ny, ny: nu, seed: seed ^ 2 });
        let at = |model: &StateSpace<Discrete>| model.frequency_response(omega).unwrap();
        let (g, h, k) = (at(&p), at(&same), at(&back));
        let tolerance = 1e-10;
        let series = at(&p.series(&back).unwrap());
        prop_assert!(distance_c(series.as_ref(), (&k * &g).as_ref()) < tolerance);
        let parallel = at(&p.parallel(&same).unwrap());
        prop_assert!((parallel - (&g + &h)).norm_l2() < tolerance * (g.norm_l2() + h.norm_l2()));
        let difference = at(&p.difference(&same).unwrap());
        prop_assert!((difference - (&g - &h)).norm_l2() < tolerance * (g.norm_l2() + h.norm_l2()));
        let both = at(&p.append(&back).unwrap());
        prop_assert!(distance_c(both.submatrix(0, 0, ny, nu), g.as_ref()) < tolerance);
        prop_assert!(distance_c(both.submatrix(ny, nu, nu, ny), k.as_ref()) < tolerance);
        // The loop is ill-posed for a null set of D; near it the comparison says nothing.
        if let Ok(closed) = p.feedback(&back) {
            let closed = at(&closed);
            let error = (&closed + &g * &k * &closed - &g).norm_l2();
            let size = (1.0 + (&g * &k).norm_l2()) * closed.norm_l2() + g.norm_l2();
            prop_assert!(error < 1e-9 * size, "{:e}", error / size);
        }
    }
}
