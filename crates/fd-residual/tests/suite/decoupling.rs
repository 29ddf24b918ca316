//! Residuals that do not know some of the inputs: unknown-input observers, left null spaces, left
//! eigenstructures, and the directions they are given.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use crate::common::{
    Draw, distance, draws, joined, peak, plant, random_matrix, residuals, rng, sampled, signal,
    simulate,
};
use faer::{Mat, Scale, c64, mat};
use fd_core::testing::reset_and_restore;
use fd_model::{Channel, Continuous, Discrete, Record, SampleTime, StateSpace};
use fd_residual::{
    DesignError, GeneratorDesign,
    analysis::{UnknownInputs, fault_effects, weak_structure},
    decouple::{DecoupledDesign, LeftNullSpace, isolability},
    disturbance::{Directions, Expectation},
    eigenstructure::EigenstructureDesign,
    observer::ErrorPoles,
    parity::ParityDesign,
    unknown_input::UnknownInputObserver,
};
use proptest::prelude::*;

/// A random plant with more outputs than unknown inputs, and their directions.
fn disturbed(draw: Draw) -> (StateSpace<Discrete>, Mat<f64>) {
    let model = plant(Draw { ny: draw.ny.max(2), ..draw });
    let e = random_matrix(&mut rng(draw.seed ^ 0xd), model.nx(), 1);
    (model, e)
}

/// The model with further inputs that enter along `e`.
fn with_unknown(model: &StateSpace<Discrete>, e: &Mat<f64>) -> StateSpace<Discrete> {
    let (n, nu, ne) = (model.nx(), model.nu(), e.ncols());
    let b =
        Mat::from_fn(n, nu + ne, |i, j| if j < nu { model.b()[(i, j)] } else { e[(i, j - nu)] });
    let d = Mat::from_fn(model.ny(), nu + ne, |i, j| if j < nu { model.d()[(i, j)] } else { 0.0 });
    StateSpace::new(model.a().to_owned(), b, model.c().to_owned(), d, model.domain()).unwrap()
}

/// Every decoupled design that exists for the plant.
fn decoupled(model: &StateSpace<Discrete>, e: &Mat<f64>) -> Vec<Box<dyn GeneratorDesign>> {
    let poles = ErrorPoles::Rate(3.0);
    let unknown = UnknownInputs::new("d", e.clone(), Mat::zeros(model.ny(), e.ncols())).unwrap();
    let mut all: Vec<Box<dyn GeneratorDesign>> =
        vec![Box::new(DecoupledDesign::new(model, &unknown, &poles).unwrap())];
    match UnknownInputObserver::place(model, e.as_ref(), &poles) {
        Ok(design) => all.push(Box::new(design)),
        // A random plant may have zeros outside the unit circle.
        Err(DesignError::UndecayingZero { re, im }) => assert!(1.0 <= re.hypot(im)),
        Err(error) => panic!("{error}"),
    }
    match EigenstructureDesign::new(model, e.as_ref(), &poles) {
        Ok(design) => all.push(Box::new(design)),
        Err(DesignError::NoEigenvector { rank, .. }) => assert_eq!(rank, model.ny()),
        Err(error) => panic!("{error}"),
    }
    all
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// The residual with an unknown input is the residual without it, sample by sample.
    #[test]
    fn unknown_inputs_do_not_reach_the_residual(draw in draws()) {
        let (model, e) = disturbed(draw);
        let (u, d) = (signal(draw.seed ^ 1, draw.nu, 60), signal(draw.seed ^ 2, 1, 60));
        let start = vec![0.3; model.nx()];
        let quiet = simulate(&model, &start, &u);
        let loud_along =
            |e: &Mat<f64>| simulate(&with_unknown(&model, e), &start, &joined(&u, &d));
        // Some directions hardly reach the outputs of some plants: as large as it takes for a mark of one.
        let e = Scale(distance(&quiet, &loud_along(&e)).recip()) * e;
        let loud = loud_along(&e);
        prop_assert!(1e-3 < distance(&quiet, &loud));
        for design in decoupled(&model, &e) {
            let r = residuals(&mut *design.build().unwrap(), &u, &quiet);
            let same = residuals(&mut *design.build().unwrap(), &u, &loud);
            // What cancels is some 1e3 times as large as y for plants that hardly show a state.
            prop_assert!(distance(&r, &same) < 1e-9 * (1.0 + peak(&loud)), "{design:?}");
            prop_assert!(design.form().unwrap().consistency(&model).unwrap() < 1e-9);
        }
    }

    /// Decoupling a fault leaves the others where it can, and one that is left alone is seen.
    #[test]
    fn a_decoupled_signature_is_zero_for_its_fault_only(draw in draws()) {
        let model = plant(Draw { ny: 3, ..draw });
        let none = UnknownInputs::none(&model);
        let faults = (0..3).fold(none.clone(), |all, i| all.sensor(&model, i).unwrap());
        let faults = faults.actuator(&model, 0).unwrap();
        let gf = faults.system(&model).unwrap();
        for ignored in 0..faults.len() {
            let space = LeftNullSpace::of(&model, &faults.select(&[ignored]).unwrap()).unwrap();
            let form = space.placed(&ErrorPoles::Rate(4.0)).unwrap();
            let expected = space.detects(&faults).unwrap();
            prop_assert!(!expected.0[ignored]);
            let rows = weak_structure(&form, &gf).unwrap();
            let seen = (0..faults.len()).map(|j| rows.iter().any(|row| row.0[j]));
            prop_assert_eq!(seen.collect::<Vec<_>>(), expected.0);
        }
    }

    /// The faults in another order give the answer in that order.
    #[test]
    fn permuting_faults_permutes_the_isolability(draw in draws(), shift in 1..4_usize) {
        let model = plant(draw);
        let none = UnknownInputs::none(&model);
        let sensors = (0..draw.ny).fold(none.clone(), |all, i| all.sensor(&model, i).unwrap());
        let faults = (0..draw.nu).fold(sensors, |all, i| all.actuator(&model, i).unwrap());
        let count = faults.len();
        let order: Vec<_> = (0..count).map(|i| (i + shift) % count).collect();
        let one = isolability(&model, &faults, &none).unwrap();
        let other = isolability(&model, &faults.select(&order).unwrap(), &none).unwrap();
        for i in 0..count {
            for j in 0..count {
                prop_assert_eq!(other[i].0[j], one[order[i]].0[order[j]]);
            }
        }
    }

    /// A dead-beat left eigenstructure is a parity relation of order one.
    #[test]
    fn a_dead_beat_eigenvector_is_a_parity_relation(draw in draws()) {
        let (model, e) = disturbed(Draw { nx: draw.nx.min(2), ny: 4, ..draw });
        let design = EigenstructureDesign::new(&model, e.as_ref(), &ErrorPoles::DeadBeat).unwrap();
        // Impulse responses of the form: W at lag 0, then W C L at lag 1, then nothing.
        let hy = GeneratorDesign::form(&design).unwrap().hy().unwrap();
        let first = hy.c() * hy.b();
        let later = hy.c() * hy.a() * hy.b();
        prop_assert!(later.norm_max() < 1e-9 * (1.0 + hy.b().norm_max()));
        let ny = model.ny();
        let vectors = Mat::from_fn(hy.ny(), 2 * ny, |i, j| {
            if j < ny { first[(i, j)] } else { hy.d()[(i, j - ny)] }
        });
        // Refused unless every row annihilates [C; C A].
        let parity = ParityDesign::with_vectors(&model, 1, vectors.as_ref()).unwrap();
        let (u, y) = (signal(draw.seed, draw.nu, 40), signal(draw.seed ^ 1, ny, 40));
        let one = residuals(&mut *design.build().unwrap(), &u, &y);
        let other = residuals(&mut *parity.build().unwrap(), &u, &y);
        // From the second sample on: the parity window is full, the observer has forgotten.
        prop_assert!(distance(&one[2..], &other[2..]) < 1e-9 * (1.0 + peak(&one)));
    }

    /// Directions that were put into the models are found again, at their rank.
    #[test]
    fn directions_are_found_in_perturbed_models(draw in draws(), rank in 1..3_usize) {
        let model = plant(Draw { nx: draw.nx.max(3), ..draw });
        let mut rng = rng(draw.seed ^ 3);
        let (n, nu) = (model.nx(), model.nu());
        let e = random_matrix(&mut rng, n, rank);
        let perturbed: Vec<_> = (0..4)
            .map(|_| {
                let a = model.a() + &e * random_matrix(&mut rng, rank, n);
                let b = model.b() + &e * random_matrix(&mut rng, rank, nu);
                let (c, d) = (model.c().to_owned(), model.d().to_owned());
                StateSpace::new(a, b, c, d, model.domain()).unwrap()
            })
            .collect();
        let found = Directions::from_models(&model, &perturbed, &vec![1.0; n + nu]).unwrap();
        prop_assert!(found.explained(rank) > 1.0 - 1e-12);
        let columns = found.columns(rank).unwrap();
        let missed = &e - columns * (columns.transpose() * &e);
        // The second moment squares the condition of four random draws.
        prop_assert!(missed.norm_max() < 1e-6, "{missed:?}");
    }
}

/// Healthy logs of a plant whose second state equation is wrong show that direction.
#[test]
fn a_wrong_equation_is_learned_from_logs_and_decoupled() {
    let a = mat![[0.9, 0.05, 0.0], [0.1, 0.85, 0.05], [0.0, 0.1, 0.8]];
    let (b, c) = (mat![[1.0], [0.2], [0.0]], Mat::identity(3, 3));
    let model =
        StateSpace::new(a.clone(), b.clone(), c.clone(), Mat::zeros(3, 1), sampled()).unwrap();
    let mut wrong = a;
    wrong[(1, 0)] = 0.2;
    wrong[(1, 1)] = 0.7;
    let real = StateSpace::new(wrong, b, c, Mat::zeros(3, 1), sampled()).unwrap();
    let u = signal(1, 1, 600);
    let noise = signal(2, 3, 600);
    let y: Vec<Vec<f64>> = simulate(&real, &[0.0; 3], &u)
        .iter()
        .zip(&noise)
        .map(|(y, v)| y.iter().zip(v).map(|(y, v)| y + 0.002 * v).collect())
        .collect();
    let rows = u.iter().zip(&y);
    let ts = SampleTime::new(0.1).unwrap();
    let log = Record::from_rows(Channel::numbered("u", 1), Channel::numbered("y", 3), rows, ts);
    let expected = Expectation { duration_s: 0.5, output_noise: 0.05, settle: 50 };
    let found = Directions::from_records(&model, &[log.unwrap()], &expected).unwrap();
    let e = found.columns(1).unwrap();
    // The other two components are noise, some 1 % of the disturbance.
    assert!(0.999 < e[(1, 0)].abs(), "{e:?}");
    assert!(0.95 < found.explained(1) && found.rank_for(0.95) == 1, "{:?}", found.sizes());
    let energy: Vec<f64> = found.sizes().iter().map(|size| size * size).collect();
    assert!((found.explained(1) - energy[0] / energy.iter().sum::<f64>()).abs() < 1e-12);

    let design = UnknownInputObserver::place(&model, e, &ErrorPoles::Rate(5.0)).unwrap();
    let plain = fd_residual::simulation::SimulationDesign::new(&model).unwrap();
    let size = |design: &dyn GeneratorDesign| {
        peak(&residuals(&mut *design.build().unwrap(), &u, &y)[50..])
    };
    // Noise of 0.002 and what leaks through a direction that is 1 % off, instead of the error.
    assert!(size(&design) < 0.05 * size(&plain), "{} {}", size(&design), size(&plain));
}

#[test]
fn conditions_are_explained() {
    // Only the second state is measured, the load acts on the first.
    let a = mat![[0.9, 0.1], [0.1, 0.8]];
    let (b, c) = (mat![[1.0], [0.0]], mat![[0.0, 1.0], [0.0, 2.0]]);
    let model = StateSpace::new(a, b, c, Mat::zeros(2, 1), sampled()).unwrap();
    let e = mat![[1.0], [0.0]];
    let error = UnknownInputObserver::place(&model, e.as_ref(), &ErrorPoles::Rate(1.0));
    let error = error.unwrap_err();
    assert_eq!(error, DesignError::HiddenDirection { rank_ce: 0, rank_e: 1 });
    assert!(error.to_string().contains("rank C E = rank E"));
    // The two outputs still agree with one another: a null space exists where the observer fails.
    let unknown = UnknownInputs::new("d", e, Mat::zeros(2, 1)).unwrap();
    assert_eq!(LeftNullSpace::of(&model, &unknown).unwrap().order(), 0);

    // A zero at z = 1.25 from the load to the first output stays as a pole.
    let a = mat![[0.5, 1.0, 0.0], [0.0, 1.25, 0.0], [0.0, 0.0, 0.3]];
    let c = mat![[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    let model = StateSpace::new(a, Mat::zeros(3, 1), c, Mat::zeros(2, 1), sampled()).unwrap();
    let e = mat![[1.0], [0.0], [0.0]];
    let error = UnknownInputObserver::place(&model, e.as_ref(), &ErrorPoles::Rate(1.0));
    match error.unwrap_err() {
        DesignError::UndecayingZero { re, im } => {
            assert!((c64::new(re, im) - c64::new(1.25, 0.0)).norm() < 1e-12);
        }
        other => panic!("{other}"),
    }
    // As many directions as outputs.
    let all = Mat::from_fn(3, 2, |i, j| if i == 2 * j { 1.0 } else { 0.0 });
    let error = UnknownInputObserver::place(&model, all.as_ref(), &ErrorPoles::Rate(1.0));
    assert_eq!(error.unwrap_err(), DesignError::NothingLeft { inputs: 2, outputs: 2 });
}

#[test]
fn decoupled_generators_obey_reset_and_restore() {
    let draw = Draw { nx: 4, nu: 2, ny: 3, radius: 0.9, seed: 7 };
    let (model, e) = disturbed(draw);
    let samples: Vec<_> = signal(1, 2, 50).into_iter().zip(signal(2, 3, 50)).collect();
    for design in decoupled(&model, &e) {
        let form = design.form().unwrap();
        let mut generator = form.freeze::<f64, fd_core::Heap, fd_core::Heap>().unwrap();
        reset_and_restore(&mut generator, &samples);
    }
}

/// Three tanks of Frisk et al. (2012) with flow and capacity faults: which can be told apart.
#[test]
fn three_tank_isolability() {
    // p' = A p + e₁ q₀ + B f for R = C = 1; measured p₁, q₂ = p₂ − p₃ + f_V2 and the input q₀.
    let a = mat![[-1.0, 1.0, 0.0], [1.0, -2.0, 1.0], [0.0, 1.0, -2.0]];
    let (b, c) = (mat![[1.0], [0.0], [0.0]], mat![[1.0, 0.0, 0.0], [0.0, 1.0, -1.0]]);
    let tanks = StateSpace::new(a, b, c, Mat::zeros(2, 1), Continuous).unwrap();
    let names = ["fV1", "fV2", "fV3", "fT1", "fT2", "fT3"];
    let into_tanks = [
        [-1.0, 1.0, 0.0],
        [0.0, -1.0, 1.0],
        [0.0, 0.0, -1.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
    ];
    let none = UnknownInputs::none(&tanks);
    let faults = names.iter().zip(into_tanks).fold(none.clone(), |all, (name, b)| {
        let d = if *name == "fV2" { [0.0, 1.0] } else { [0.0, 0.0] };
        all.component(name, &b, &d).unwrap()
    });
    let found = isolability(&tanks, &faults, &none).unwrap();
    let group = ["fV2", "fV3", "fT3"];
    for (i, row) in found.iter().enumerate() {
        for (j, &told_apart) in row.0.iter().enumerate() {
            let same = i != j && group.contains(&names[i]) && group.contains(&names[j]);
            assert_eq!(told_apart, !same, "{} from {}", names[i], names[j]);
        }
    }
}

/// Continuous designs are analysed in the same way.
#[test]
fn continuous_designs_are_decoupled() {
    let a = mat![[-1.0, 1.0, 0.0], [1.0, -2.0, 1.0], [0.0, 1.0, -2.0]];
    let b = mat![[1.0], [0.0], [0.0]];
    let tanks = StateSpace::new(a, b, Mat::identity(3, 3), Mat::zeros(3, 1), Continuous).unwrap();
    let e = mat![[0.0], [1.0], [0.0]];
    let gd = UnknownInputs::new("d", e.clone(), Mat::zeros(3, 1)).unwrap().system(&tanks).unwrap();
    let poles = ErrorPoles::Rate(4.0);
    let forms = [
        UnknownInputObserver::place(&tanks, e.as_ref(), &poles).unwrap().form().unwrap(),
        EigenstructureDesign::new(&tanks, e.as_ref(), &poles).unwrap().form().unwrap(),
    ];
    for form in forms {
        assert!(form.consistency(&tanks).unwrap() < 1e-12);
        assert!(!fault_effects(&form, &gd).unwrap()[0].detectable);
    }
}

/// No continuous error is gone after finitely many samples.
#[test]
fn dead_beat_needs_samples() {
    let (a, c) = (mat![[-1.0, 0.5], [0.0, -2.0]], Mat::identity(2, 2));
    let (b, d) = (mat![[1.0], [1.0]], Mat::zeros(2, 1));
    let e = mat![[1.0], [0.0]];
    let model = StateSpace::new(a.clone(), b.clone(), c.clone(), d.clone(), Continuous).unwrap();
    let refused = UnknownInputObserver::place(&model, e.as_ref(), &ErrorPoles::DeadBeat);
    assert!(matches!(refused, Err(DesignError::Speed { factor }) if factor.is_infinite()));
    let model = StateSpace::new(a, b, c, d, sampled()).unwrap();
    UnknownInputObserver::place(&model, e.as_ref(), &ErrorPoles::DeadBeat).unwrap();
}
