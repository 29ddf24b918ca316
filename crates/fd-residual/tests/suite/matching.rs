//! Model matching and filters of least order: examples in closed form, and laws on random plants.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common::{
    Draw, draws, plant, random_matrix, residuals, rng, sampled, signal, simulate,
    transfer::{assert_equal, realise},
};
use faer::{Mat, Scale, mat};
use fd_model::{Continuous, Discrete, StateSpace, TimeDomain};
use fd_numeric::dense::Dense;
use fd_residual::{
    DesignError, GeneratorDesign,
    analysis::{Signature, UnknownInputs, weak_structure},
    least_order::LeastOrderDesign,
    matching::{ApproximateMatching, ExactMatching, MatchingNorm},
    observer::ErrorPoles,
    optimal::Exposure,
};
use proptest::prelude::*;

/// Example 5.13 of Varga (2017): a zero at the origin and one at infinity, and a combination of outputs that avoids all
/// others. In closed form `Q = M [0 (s+1)/s 0 −1 0; 0 0 (s+2) 0 −1]` with `M` as given below; the published `M` differs in
/// its free poles.
#[test]
fn zeros_on_the_edge_go_into_the_update() {
    let rows = [
        [(&[1.0, 0.0][..], &[1.0, 3.0, 2.0][..]), (&[1.0], &[1.0, 2.0])],
        [(&[1.0, 0.0], &[1.0, 1.0]), crate::common::transfer::ZERO],
        [crate::common::transfer::ZERO, (&[1.0], &[1.0, 2.0])],
    ];
    let model = realise(&rows);
    let none = UnknownInputs::none(&model);
    let faults = none.clone().actuator(&model, 0).unwrap().actuator(&model, 1).unwrap();
    let wanted = StateSpace::gain(Mat::identity(2, 2), Continuous).unwrap();
    let design = ExactMatching::new(&model, &faults, &none, &wanted, 1.0).unwrap();
    // The zero s = 0, mirrored in the line Re s = −0.999, and a lag twice as fast as the rate.
    let expected = realise(&[
        [(&[1.0, 0.0][..], &[1.0, 1.998][..]), crate::common::transfer::ZERO],
        [crate::common::transfer::ZERO, (&[2.0], &[1.0, 2.0])],
    ]);
    assert_equal(&design.update().unwrap(), &expected);
    let made = design.form().residual_of(&faults.system(&model).unwrap()).unwrap();
    for omega in [0.0, 0.3, 2.0, 50.0] {
        let (made, wanted) =
            (made.frequency_response(omega).unwrap(), expected.frequency_response(omega).unwrap());
        assert!((made - wanted).norm_max() < 1e-8);
    }
    assert!(design.form().consistency(&model).unwrap() < 1e-9);
}

/// Example 5.6 of Varga (2017), the sum of both outputs against the sum of both faults. At rest `[1, 1, 0] − q [1/2, 1, 1/2]` has
/// the least norm `√½`, and no other frequency is worse: the bound is reached.
#[test]
fn the_worst_frequency_decides() {
    let model = realise(&[[(&[2.0, 8.0, 7.0][..], &[1.0, 5.0, 6.0][..])]]);
    // The faults (s+1)/(s+2) and 1, and the noise 1/(s+2), on the same output.
    let others = realise(&[[
        (&[1.0, 1.0][..], &[1.0, 2.0][..]),
        crate::common::transfer::ONE,
        (&[1.0], &[1.0, 2.0]),
    ]]);
    let all = model.beside(&others).unwrap();
    let plant = all.select(&[0], &[0]).unwrap();
    let of = |inputs: &[usize]| {
        let part = all.select(&[0], inputs).unwrap();
        UnknownInputs::new("f", part.b().to_owned(), part.d().to_owned()).unwrap()
    };
    let (faults, noise, none) = (of(&[1, 2]), of(&[3]), UnknownInputs::none(&plant));
    let exposure = Exposure { faults: &faults, disturbances: &none, noise: &noise };
    let wanted = StateSpace::gain(mat![[1.0, 1.0]], Continuous).unwrap();
    let design =
        ApproximateMatching::new(&plant, &exposure, &wanted, 3.0, MatchingNorm::Peak).unwrap();
    let error = design.error(&plant, &exposure, &wanted).unwrap().hinf_norm(1e-8).unwrap().norm;
    // The search stops within 1e-4.
    let least = 0.5_f64.sqrt();
    assert!(least * (1.0 - 1e-9) <= error && error <= least * (1.0 + 2e-4), "{error}");
    assert!((design.distance() / error - 1.0).abs() < 1e-6 && design.bound() <= error);
}

/// Example 5.12 of Varga (2017), voting among three sensors of one signal: pairs of outputs match the reference as it is, with
/// `M = I` and no dynamics. The model holds the states of the signal once per sensor.
#[test]
fn states_that_are_held_several_times_cost_nothing() {
    let (signal, load): (crate::common::transfer::Ratio, crate::common::transfer::Ratio) =
        ((&[1.0], &[1.0, 0.4, 1.0]), (&[1.0, 3.0], &[1.0, 2.0, 5.0]));
    let all = realise(&[[signal, load], [signal, load], [signal, load]]);
    let model = all.select(&[0, 1, 2], &[0]).unwrap();
    let entry = all.select(&[0, 1, 2], &[1]).unwrap();
    let hidden = UnknownInputs::new("load", entry.b().to_owned(), entry.d().to_owned()).unwrap();
    let sensors = (0..3).fold(UnknownInputs::none(&model), |all, i| all.sensor(&model, i).unwrap());
    let pairs = mat![[0.0, 1.0, -1.0], [-1.0, 0.0, 1.0], [1.0, -1.0, 0.0]];
    let wanted = StateSpace::gain(pairs.clone(), Continuous).unwrap();
    let design = ExactMatching::new(&model, &sensors, &hidden, &wanted, 1.0).unwrap();
    for omega in [0.0, 0.5, 3.0, 100.0] {
        let update = design.update().unwrap().frequency_response(omega).unwrap();
        let (from_u, from_y) = design.form().response(omega).unwrap();
        for i in 0..3 {
            assert!(from_u[(i, 0)].norm() < 1e-9);
            for j in 0..3 {
                let unit = if i == j { 1.0 } else { 0.0 };
                assert!((update[(i, j)] - unit).norm() < 1e-9, "{omega}: {update:?}");
                assert!((from_y[(i, j)] - pairs[(i, j)]).norm() < 1e-9, "{omega}: {from_y:?}");
            }
        }
    }
}

/// A state that nothing moves is left out only if it dies out: residuals are blind to an offset that stays.
#[test]
fn an_offset_that_stays_is_not_left_out() {
    // A lag with an integrator at rest on each of its two outputs.
    let a = mat![[-1.0, 0.0], [0.0, 0.0]];
    let (b, c) = (mat![[1.0], [0.0]], mat![[1.0, 1.0], [0.0, 1.0]]);
    let model = StateSpace::new(a, b, c, Mat::zeros(2, 1), Continuous).unwrap();
    let none = UnknownInputs::none(&model);
    let fault = none.clone().actuator(&model, 0).unwrap();
    let wanted = realise(&[[(&[1.0][..], &[1.0, 1.0][..])]]);
    let design = ExactMatching::new(&model, &fault, &none, &wanted, 1.0).unwrap();
    // Constant outputs as the offset makes them, and no input.
    let (_, from_y) = design.form().response(0.0).unwrap();
    assert!((from_y[(0, 0)] + from_y[(0, 1)]).norm() < 1e-9, "{from_y:?}");
}

/// A reference that tells apart what the outputs do not.
#[test]
fn what_outputs_do_not_tell_apart_is_refused() {
    let c = mat![[1.0], [2.0]];
    let lag = StateSpace::new(mat![[-1.0]], mat![[1.0]], c, Mat::zeros(2, 1), Continuous).unwrap();
    let none = UnknownInputs::none(&lag);
    let twice =
        none.clone().actuator(&lag, 0).unwrap().component("leak", &[-0.5], &[0.0, 0.0]).unwrap();
    let apart = StateSpace::gain(Mat::identity(2, 2), Continuous).unwrap();
    let refused = ExactMatching::new(&lag, &twice, &none, &apart, 1.0).unwrap_err();
    assert!(matches!(refused, DesignError::NotMatched { missed } if 0.1 < missed), "{refused}");
    // What depends on their difference as they do can be had.
    let together = StateSpace::gain(mat![[1.0, -0.5]], Continuous).unwrap();
    let design = ExactMatching::new(&lag, &twice, &none, &together, 1.0).unwrap();
    assert!(design.missed() < 1e-9);
    let unstable =
        StateSpace::new(mat![[1.0]], mat![[1.0, 0.0]], mat![[1.0]], mat![[0.0, 0.0]], Continuous);
    assert!(ExactMatching::new(&lag, &twice, &none, &unstable.unwrap(), 1.0).is_err());
}

/// `M_r = 1`, `G_f = (1 − s)/(1 + s)` and no noise: `1 − q G_f` is one at `s = 1` for every stable `q`, so the distance is
/// one and `q = 0` is as good as any. With `M_r = 1/(s + 1)` it is `M_r(1) = 1/2` (Nehari; interpolation of Nevanlinna and
/// Pick at one point).
#[test]
fn a_zero_that_grows_costs_what_interpolation_says() {
    let model = realise(&[[(&[-1.0, 1.0][..], &[1.0, 1.0][..])]]);
    let none = UnknownInputs::none(&model);
    let fault = none.clone().actuator(&model, 0).unwrap();
    let exposure = Exposure { faults: &fault, disturbances: &none, noise: &none };
    let one = realise(&[[crate::common::transfer::ONE]]);
    let lag = realise(&[[(&[1.0][..], &[1.0, 1.0][..])]]);
    for (wanted, expected) in [(one, 1.0), (lag, 0.5)] {
        let peak = MatchingNorm::Peak;
        let design = ApproximateMatching::new(&model, &exposure, &wanted, 2.0, peak).unwrap();
        assert!((design.distance() / expected - 1.0).abs() < 2e-4, "{}", design.distance());
        assert!(design.bound() <= design.distance());
    }
}

/// The H2 filter of a static problem is least squares: `q = g/(g² + σ²)`.
#[test]
fn the_h2_match_is_least_squares() {
    let (g, sigma) = (2.0, 0.5);
    let plant =
        StateSpace::new(Mat::zeros(0, 0), Mat::zeros(0, 1), Mat::zeros(1, 0), mat![[g]], sampled())
            .unwrap();
    let none = UnknownInputs::none(&plant);
    let fault = none.clone().actuator(&plant, 0).unwrap();
    let noise = UnknownInputs::new("w", Mat::zeros(0, 1), mat![[sigma]]).unwrap();
    let exposure = Exposure { faults: &fault, disturbances: &none, noise: &noise };
    let wanted = StateSpace::gain(mat![[1.0]], sampled()).unwrap();
    let design =
        ApproximateMatching::new(&plant, &exposure, &wanted, 1.0, MatchingNorm::Peak).unwrap();
    let q = design.form().system().d()[(0, 1)];
    assert!((q - g / (g * g + sigma * sigma)).abs() < 1e-3, "{q}");
    assert!((design.distance() - sigma / g.hypot(sigma)).abs() < 1e-4);
}

/// Faults of all sensors of a drawn plant, seen through a mixture that a stable reference asks for.
fn problem(draw: Draw) -> (StateSpace<Discrete>, UnknownInputs, StateSpace<Discrete>) {
    let model = plant(draw);
    let mut rng = rng(draw.seed ^ 9);
    let b = random_matrix(&mut rng, draw.nx, draw.ny);
    let d = Mat::<f64>::identity(draw.ny, draw.ny)
        + Scale(0.2) * random_matrix(&mut rng, draw.ny, draw.ny);
    let faults = UnknownInputs::new("f", b, d).unwrap();
    let reference = StateSpace::new(
        Mat::from_fn(draw.ny, draw.ny, |i, j| if i == j { 0.5 } else { 0.0 }),
        random_matrix(&mut rng, draw.ny, draw.ny),
        Mat::identity(draw.ny, draw.ny),
        random_matrix(&mut rng, draw.ny, draw.ny),
        model.domain(),
    );
    (model, faults, reference.unwrap())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// The residual's way from the faults is the updated reference, it is free of the input, and what runs shows it.
    #[test]
    fn an_exact_match_is_the_reference(draw in draws()) {
        let draw = Draw { ny: draw.ny.min(3), nx: draw.nx.min(4), ..draw };
        let (model, faults, reference) = problem(draw);
        let none = UnknownInputs::none(&model);
        let design = ExactMatching::new(&model, &faults, &none, &reference, 1.0);
        // A drawn fault may have zeros beside the circle, where a mirrored mode is hardly moved.
        prop_assume!(design.is_ok());
        let design = design.unwrap();
        prop_assert!(design.missed() < 1e-6);
        prop_assert!(design.form().consistency(&model).unwrap() < 1e-6);
        for update in design.updates() {
            prop_assert!(update.is_stable().unwrap());
        }
        let gf = faults.system(&model).unwrap();
        let f = signal(draw.seed ^ 4, draw.ny, 300);
        let y = simulate(&gf, &vec![0.0; draw.nx], &f);
        let zero = vec![vec![0.0; draw.nu]; 300];
        let r = residuals(&mut *design.build().unwrap(), &zero, &y);
        let expected = simulate(design.target(), &vec![0.0; design.target().nx()], &f);
        prop_assert!(crate::common::distance(&r, &expected) < 1e-5 * (1.0 + crate::common::peak(&expected)));
    }

    /// The distance is what the error system has, it lies at the bound, no drawn filter is nearer, and H2 is not nearer in the
    /// largest gain.
    #[test]
    fn an_approximate_match_is_nearest(draw in draws()) {
        let draw = Draw { ny: draw.ny.min(2), nx: draw.nx.min(4), ..draw };
        let (model, faults, reference) = problem(draw);
        let mut rng = rng(draw.seed ^ 5);
        let into = random_matrix(&mut rng, draw.nx, draw.ny);
        let direct = Scale(0.5) * Mat::<f64>::identity(draw.ny, draw.ny);
        let noise = UnknownInputs::new("w", into, direct).unwrap();
        let none = UnknownInputs::none(&model);
        let exposure = Exposure { faults: &faults, disturbances: &none, noise: &noise };
        let of = |norm| ApproximateMatching::new(&model, &exposure, &reference, 1.0, norm).unwrap();
        let best = of(MatchingNorm::Peak);
        let norm = |design: &ApproximateMatching| {
            design.error(&model, &exposure, &reference).unwrap().hinf_norm(1e-7).unwrap().norm
        };
        prop_assert_eq!(best.lags(), 0);
        prop_assert!((norm(&best) / best.distance() - 1.0).abs() < 1e-5);
        prop_assert!(best.distance() <= best.bound() * (1.0 + 3e-4) + 1e-9);
        prop_assert!(best.distance() <= norm(&of(MatchingNorm::H2)) * (1.0 + 1e-6));
        prop_assert!(best.form().consistency(&model).unwrap() < 1e-8);
        // At each frequency alone no filter does better than this.
        let all = faults.and(&noise).unwrap().system(&model).unwrap();
        for omega in [0.0, 1.0, 10.0, model.domain().highest_frequency()] {
            let (g, m) = (all.frequency_response(omega).unwrap(), reference.frequency_response(omega).unwrap());
            let wide = Mat::from_fn(m.nrows(), g.ncols(), |i, j| if j < m.ncols() { m[(i, j)] } else { faer::c64::new(0.0, 0.0) });
            let svd = g.economic_svd().unwrap();
            let rest = &wide - &wide * svd.V() * svd.V().adjoint();
            let least = rest.sigmas().unwrap()[0];
            prop_assert!(least <= best.distance() * (1.0 + 1e-7));
        }
    }

    /// A filter of least order reacts to what it should, has the poles it was given, and there is none of a lower order.
    #[test]
    fn filters_of_least_order_keep_their_word(draw in draws(), bits in 1..8_usize) {
        let model = plant(Draw { ny: draw.ny.max(2), ..draw });
        let none = UnknownInputs::none(&model);
        let into = random_matrix(&mut rng(draw.seed ^ 3), draw.nx, 3);
        let direct = Mat::from_fn(model.ny(), 3, |i, j| if i == j && j < 2 { 1.0 } else { 0.0 });
        let faults = UnknownInputs::new("f", into, direct).unwrap();
        let wanted = Signature((0..3).map(|k| bits >> k & 1 == 1).collect());
        let found = LeastOrderDesign::new(&model, &faults, &none, &wanted, &ErrorPoles::Rate(2.0));
        let longest = draw.nx + 3;
        let parity = fd_residual::parity::ParityDesign::with_signature(&model, &faults, &none, &wanted, longest);
        prop_assert_eq!(found.is_ok(), parity.is_ok());
        if let (Ok(found), Ok(parity)) = (found, parity) {
            prop_assert_eq!(found.order(), parity.order());
            prop_assert!(found.form().consistency(&model).unwrap() < 1e-8);
            let gf = faults.system(&model).unwrap();
            prop_assert_eq!(weak_structure(found.form(), &gf).unwrap(), vec![wanted]);
            // As a parity relation when all poles are at the origin.
            let dead = vec![faer::c64::new(0.0, 0.0); found.order()];
            let wanted = &weak_structure(found.form(), &gf).unwrap()[0];
            let dead = LeastOrderDesign::new(&model, &faults, &none, wanted, &ErrorPoles::Given(dead)).unwrap();
            let (one, two) = (dead.form().response(1.0).unwrap().1, parity.form().unwrap().response(1.0).unwrap().1);
            // Of the whole row: one of its entries may be nothing but rounding.
            let along = |row: &Mat<faer::c64>| (row * two.adjoint())[(0, 0)];
            let factor = along(&one) / along(&two);
            let error = Mat::from_fn(1, one.ncols(), |_, j| one[(0, j)] - factor * two[(0, j)]).norm_l2();
            prop_assert!(error < 1e-8 * one.norm_l2());
        }
    }
}
