//! Parity vectors: exact ones, the closest ones, and the ones that do not exist.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use crate::common::{
    Draw, draws, peak, plant, problems::yuan, random_matrix, residuals, rng, sampled, signal,
    simulate,
};
use faer::{Mat, Scale, mat};
use fd_model::{ModelError, StateSpace};
use fd_residual::{
    DesignError, GeneratorDesign,
    analysis::{Signature, UnknownInputs, weak_structure},
    parity::ParityDesign,
    simulation::SimulationDesign,
};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// As soon as the window is full, whatever the state and however unstable the plant.
    #[test]
    fn the_state_is_ignored_exactly(draw in draws(), radius in 0.5..1.3_f64) {
        let model = plant(Draw { radius, ..draw });
        let u = signal(draw.seed ^ 1, draw.nu, 20);
        let x0 = signal(draw.seed ^ 2, draw.nx, 1).remove(0);
        let y = simulate(&model, &x0, &u);
        let design = ParityDesign::all(&model, draw.nx).unwrap();
        let r = residuals(&mut *design.build().unwrap(), &u, &y);
        prop_assert!(peak(&r[..draw.nx]) < f64::MIN_POSITIVE, "not full: zero by definition");
        // Unit vectors times windows of y; the rank tolerance of 1e-10 bounds what is left, in
        // practice rounding.
        prop_assert!(peak(&r) < 1e-12 * (1.0 + peak(&y)), "{:e} of {:e}", peak(&r), peak(&y));
        prop_assert!(design.leak().iter().all(|&leak| leak < 1e-14));
    }

    /// The vectors are as many as rows less rank, and orthonormal.
    #[test]
    fn all_vectors_are_found(draw in draws()) {
        let model = plant(draw);
        let design = ParityDesign::all(&model, draw.nx).unwrap();
        let rank = design.rank().unwrap();
        prop_assert_eq!(rank.rows, (draw.nx + 1) * draw.ny);
        prop_assert_eq!(design.vectors().nrows(), rank.rows - rank.rank);
        prop_assert!(rank.rank <= draw.nx);
        let w = design.vectors();
        let eye = Mat::<f64>::identity(w.nrows(), w.nrows());
        prop_assert!((w * w.transpose() - eye).norm_max() < 1e-13);
    }

    /// A decoupled disturbance of any shape does not reach the residual, another one does.
    #[test]
    fn disturbances_are_decoupled(draw in draws()) {
        prop_assume!(2 <= draw.ny);
        let model = plant(draw);
        let mut random = rng(draw.seed ^ 9);
        let b = random_matrix(&mut random, draw.nx, 2);
        let no_d = Mat::zeros(draw.ny, 1);
        let d = UnknownInputs::new("d", b.subcols(0, 1).to_owned(), no_d.clone()).unwrap();
        let order = 2 * draw.nx;
        let design = ParityDesign::decoupled(&model, order, &d).unwrap();
        let form = design.form().unwrap();
        let through = form.residual_of(&d.system(&model).unwrap()).unwrap();
        let pulse: Vec<_> = (0..order + 8).map(|k| vec![if k == 2 { 1.0 } else { 0.0 }]).collect();
        let seen = peak(&simulate(&through, &vec![0.0; through.nx()], &pulse));
        prop_assert!(seen < 1e-12, "{seen:e}");
        let other = UnknownInputs::new("d", b.subcols(1, 1).to_owned(), no_d).unwrap();
        let through = form.residual_of(&other.system(&model).unwrap()).unwrap();
        let seen = peak(&simulate(&through, &vec![0.0; through.nx()], &pulse));
        // One state leaves only one direction, which is the same for both.
        prop_assert!(draw.nx == 1 || 1e-9 < seen, "{seen:e}");
    }

    /// No unit vectors annihilate several models better than those that are called closest.
    #[test]
    fn the_closest_vectors_are_closest(draw in draws(), spread in 0.01..0.2_f64) {
        let nominal = plant(draw);
        let mut random = rng(draw.seed ^ 9);
        let models: Vec<_> = (0..3)
            .map(|_| {
                let change = Scale(spread) * random_matrix(&mut random, draw.nx, draw.nx);
                StateSpace::new(
                    nominal.a() + change,
                    nominal.b().to_owned(),
                    nominal.c().to_owned(),
                    nominal.d().to_owned(),
                    nominal.domain(),
                )
                .unwrap()
            })
            .collect();
        let order = draw.nx;
        let design = ParityDesign::closest(&models, order, 1).unwrap();
        let leak = |w: &Mat<f64>| -> f64 {
            models
                .iter()
                .map(|m| {
                    let mut left = 0.0;
                    let mut ca = m.c().to_owned();
                    let mut sum = Mat::zeros(1, draw.nx);
                    for i in 0..=order {
                        sum += w.subcols(i * draw.ny, draw.ny) * &ca;
                        ca = &ca * m.a();
                    }
                    left += sum.norm_l2().powi(2);
                    left
                })
                .sum::<f64>()
                .sqrt()
        };
        let best = leak(&design.vectors().to_owned());
        for _ in 0..30 {
            let w = random_matrix(&mut random, 1, (order + 1) * draw.ny);
            let w = Scale(w.norm_l2().recip()) * w;
            prop_assert!(best <= leak(&w) + 1e-14);
        }
    }
}

/// The leak is what passes of the state next to the most that could: of lags with the poles 0.5 and
/// 0.6, `Γ = [1 1; 0.5 0.6]` has `ΓΓᵀ = [2 1.1; 1.1 0.61]`, of trace 2.61 and determinant 0.01.
#[test]
fn the_leak_is_relative_to_the_worst_vector() {
    let lag = |pole: f64| {
        StateSpace::new(mat![[pole]], mat![[1.0]], mat![[1.0]], mat![[0.0]], sampled()).unwrap()
    };
    let design = ParityDesign::closest(&[lag(0.5), lag(0.6)], 1, 2).unwrap();
    let root = (2.61_f64.powi(2) - 0.04).sqrt();
    let smallest = ((2.61 - root) / (2.61 + root)).sqrt();
    let [best, worst] = design.leak() else { panic!("two vectors") };
    assert!((best / smallest - 1.0).abs() < 1e-12, "{best}, not {smallest}");
    assert!((worst - 1.0).abs() < 1e-15, "{worst}");
    // A single model leaves nothing.
    assert!(ParityDesign::closest(&[lag(0.5)], 1, 1).unwrap().leak()[0] < 1e-15);
}

#[test]
fn one_exact_model_makes_the_closest_vectors_exact() {
    let model = plant(Draw { nx: 3, nu: 1, ny: 2, radius: 0.9, seed: 4 });
    let design = ParityDesign::closest(std::slice::from_ref(&model), 3, 2).unwrap();
    assert!(design.leak().iter().all(|&leak| leak < 1e-15), "{:?}", design.leak());
    assert!(design.form().unwrap().consistency(&model).unwrap() < 1e-12);
}

#[test]
fn impossible_vectors_are_refused() {
    let model = plant(Draw { nx: 4, nu: 1, ny: 1, radius: 0.9, seed: 5 });
    let error = ParityDesign::all(&model, 3).unwrap_err();
    assert!(
        matches!(error, DesignError::NoParity { order: 3, rank: 4, rows: 4, smallest } if smallest > 1e-10),
        "{error}"
    );
    assert!(ParityDesign::all(&model, 4).is_ok());

    let w = mat![[1.0, 0.0, 0.0, 0.0, 0.0]];
    let error = ParityDesign::with_vectors(&model, 4, w.as_ref()).unwrap_err();
    assert!(matches!(error, DesignError::NotParity { row: 0, residue } if residue > 0.01));
    let right = ParityDesign::all(&model, 4).unwrap();
    assert!(ParityDesign::with_vectors(&model, 4, right.vectors()).is_ok());
    let narrow = right.vectors().subcols(0, 4);
    let error = ParityDesign::with_vectors(&model, 4, narrow).unwrap_err();
    assert!(matches!(error, DesignError::Shape(_)));
    let error = right.select(&[1]).unwrap_err();
    assert_eq!(error, DesignError::Index { what: "parity vector", index: 1, count: 1 });

    let other = plant(Draw { nx: 3, nu: 1, ny: 1, radius: 0.9, seed: 5 });
    let unknown = UnknownInputs::none(&other);
    assert!(matches!(
        ParityDesign::decoupled(&model, 4, &unknown),
        Err(DesignError::Model(ModelError::Shape(_)))
    ));
    assert!(matches!(ParityDesign::closest(&[], 4, 1), Err(DesignError::Empty { .. })));
}

#[test]
fn an_unstable_plant_needs_more_than_simulation() {
    let model = StateSpace::new(
        mat![[0.5, 0.2], [0.0, 1.1]],
        mat![[1.0], [1.0]],
        mat![[1.0, 0.0]],
        mat![[0.0]],
        sampled(),
    )
    .unwrap();
    let error = SimulationDesign::new(&model).unwrap_err();
    assert!(
        matches!(error, DesignError::Model(ModelError::Unstable { re, im, .. })
            if (re - 1.1).abs() < 1e-14 && im.abs() < 1e-14),
        "{error}"
    );
    let design = ParityDesign::all(&model, 2).unwrap();
    assert!(design.form().unwrap().consistency(&model).unwrap() < 1e-14);
}

/// The eighteen signatures of Yuan et al. (1997), realised at their published least orders.
#[test]
fn published_signatures_are_realised_at_least_order() {
    // The algebra does not care whether the matrices are of continuous or discrete time.
    let problem = yuan();
    let (plant, faults, none) = (problem.as_sampled(), problem.faults, problem.disturbances);
    let gf = faults.system(&plant).unwrap();
    let signature = |bits: &str| Signature(bits.bytes().map(|b| b == b'1').collect());
    let design =
        |bits: &str| ParityDesign::with_signature(&plant, &faults, &none, &signature(bits), 4);
    for (bits, order) in [
        ("00010011", 1),
        ("01101110", 2),
        ("10101110", 1),
        ("10111101", 1),
        ("10111111", 1),
        ("11001100", 2),
        ("11100110", 2),
        ("11111111", 2),
    ] {
        let design = design(bits).unwrap();
        assert_eq!(design.order(), order, "{bits}");
        let form = design.form().unwrap();
        assert_eq!(weak_structure(&form, &gf).unwrap(), [signature(bits)]);
        assert!(form.consistency(&plant).unwrap() < 1e-12);
    }
    for bits in ["00000001", "11110000", "10101111"] {
        let error = DesignError::NoSignature { signature: signature(bits), longest: 4 };
        assert_eq!(design(bits).unwrap_err(), error);
    }
}
