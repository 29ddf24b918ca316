//! Residuals that say which fault and how large, and residuals that follow the plant.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use crate::common::{
    Draw, draws, joined, peak, plant, plus, random_matrix, residuals, rng, sampled, signal,
    simulate,
};
use faer::{Mat, mat};
use fd_core::{Scalar, stage::ResidualGenerator, testing::reset_and_restore};
use fd_model::{Discrete, StateSpace};
use fd_numeric::dense::Dense;
use fd_residual::{
    DesignError, GeneratorDesign,
    adaptive::{AdaptiveDesign, ParameterNoise, ParameterShift},
    analysis::{Signature, UnknownInputs, fault_to_noise_gap, weak_structure},
    directional::{BeardDesign, FaultSpans},
    estimation::{FaultEstimatorDesign, FaultNoise},
    observer::ObserverDesign,
    optimal::{Exposure, OptimalDesign},
    simulation::SimulationDesign,
    structured::{RowMethod, Structure, StructuredDesign},
};
use proptest::prelude::*;
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;

fn sensors(model: &StateSpace<Discrete>) -> UnknownInputs {
    let none = UnknownInputs::none(model);
    (0..model.ny()).fold(none, |all, i| all.sensor(model, i).unwrap())
}

/// A standard normal number (Box and Muller).
fn normal(rng: &mut Xoshiro256PlusPlus) -> f64 {
    let (u, v): (f64, f64) = (rng.random(), rng.random());
    (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// The structure matrix of the bank is the one that was asked for, with either method.
    #[test]
    fn a_bank_has_the_structure_that_was_asked_for(draw in draws()) {
        let model = plant(Draw { nx: draw.nx.min(4), ny: 3, ..draw });
        let (faults, none) = (sensors(&model), UnknownInputs::none(&model));
        let gf = faults.system(&model).unwrap();
        let rows = vec![Signature(vec![true, true, false]), Signature(vec![false, true, true])];
        for structure in [Structure::Generalised, Structure::Rows(rows)] {
            for method in [RowMethod::Parity { longest: 6 }, RowMethod::Filter { rate: 4.0 }] {
                let bank =
                    StructuredDesign::new(&model, &faults, &none, &structure, method).unwrap();
                let found = weak_structure(&bank.form().unwrap(), &gf).unwrap();
                prop_assert_eq!(&found, &structure.rows(3).unwrap());
                prop_assert_eq!(&found, bank.signatures());
            }
        }
    }

    /// Faults in another order: residuals in that order that see the same, of the same orders.
    #[test]
    fn permuting_faults_permutes_the_bank(draw in draws(), shift in 1..3_usize) {
        let model = plant(Draw { nx: draw.nx.min(4), ny: 3, ..draw });
        let (faults, none) = (sensors(&model), UnknownInputs::none(&model));
        let order: Vec<_> = (0..3).map(|i| (i + shift) % 3).collect();
        let method = RowMethod::Parity { longest: 6 };
        let design = |faults: &UnknownInputs| {
            StructuredDesign::new(&model, faults, &none, &Structure::Generalised, method).unwrap()
        };
        let (one, other) = (design(&faults), design(&faults.select(&order).unwrap()));
        let permuted: Vec<_> = order.iter().map(|&i| one.orders()[i]).collect();
        prop_assert_eq!(other.orders(), &permuted);
        // Where the null space leaves a choice, the combination is not unique; what it sees is.
        let seen = |bank: &StructuredDesign| {
            weak_structure(&bank.form().unwrap(), &faults.system(&model).unwrap()).unwrap()
        };
        let (one_sees, other_sees) = (seen(&one), seen(&other));
        let permuted: Vec<_> = order.iter().map(|&i| one_sees[i].clone()).collect();
        prop_assert_eq!(other_sees, permuted);
    }

    /// The optimal residual's noise has unit gain at every frequency, and no other generator has
    /// a wider gap between the weakest fault and the noise.
    #[test]
    fn the_optimal_residual_is_white_and_has_the_widest_gap(draw in draws()) {
        let model = plant(Draw { nx: draw.nx.min(4), ny: draw.ny.min(3), ..draw });
        let (n, ny) = (model.nx(), model.ny());
        let mut rng = rng(draw.seed ^ 0xa);
        let into = random_matrix(&mut rng, n, n + ny);
        let direct = Mat::from_fn(ny, n + ny, |i, j| if i + n == j { 0.5 } else { 0.0 });
        let noise = UnknownInputs::new("w", into, direct).unwrap();
        let (faults, none) = (sensors(&model), UnknownInputs::none(&model));
        let exposure = Exposure { faults: &faults, disturbances: &none, noise: &noise };
        let design = OptimalDesign::new(&model, &exposure, 1.0).unwrap();
        prop_assert_eq!(design.noisy(), ny);
        let (gf, gw) = (faults.system(&model).unwrap(), noise.system(&model).unwrap());
        let rw = design.form().residual_of(&gw).unwrap();
        for omega in [0.0, 0.3, 2.0, 10.0, 31.0] {
            let g = rw.frequency_response(omega).unwrap();
            for s in g.sigmas().unwrap() {
                // Riccati residual 1e-14, times the conditioning of the innovations (< 1e3).
                prop_assert!((s - 1.0).abs() < 1e-8, "{s} at {omega}");
            }
        }
        let best = fault_to_noise_gap(design.form(), &gf, &gw).unwrap().ratio;
        let others: [Box<dyn GeneratorDesign>; 3] = [
            Box::new(SimulationDesign::new(&model).unwrap()),
            Box::new(ObserverDesign::kalman(&model, 1.0, 1.0).unwrap()),
            Box::new(ObserverDesign::kalman(&model, 0.01, 1.0).unwrap()),
        ];
        for other in others {
            let gap = fault_to_noise_gap(&other.form().unwrap(), &gf, &gw).unwrap().ratio;
            prop_assert!(gap < best * (1.0 + 1e-6), "{gap} {best}");
        }
    }

    /// A fault along an event direction keeps the residual on its line; another does not.
    #[test]
    fn beard_residuals_keep_their_direction(draw in draws()) {
        let model = plant(Draw { nx: draw.nx.max(3), ny: 4, ..draw });
        let e = random_matrix(&mut rng(draw.seed ^ 5), model.nx(), 2);
        let filter = match BeardDesign::for_events(&model, e.as_ref(), 3.0) {
            Err(DesignError::UndecayingZero { re, im }) => {
                prop_assert!(1.0 <= re.hypot(im));
                return Ok(());
            }
            filter => filter.unwrap(),
        };
        let ce = model.c() * &e;
        let lines = [ce.subcols(0, 1), ce.subcols(1, 1)];
        let mut spans = FaultSpans::<f64>::new(&lines).unwrap();
        let entry = UnknownInputs::new("e", e.clone(), Mat::zeros(4, 2)).unwrap();
        let g = entry.system(&model).unwrap();
        let u = vec![vec![0.0; draw.nu]; 40];
        for fault in 0..2 {
            let f: Vec<Vec<f64>> = signal(draw.seed ^ 6, 1, 40)
                .iter()
                .map(|f| (0..2).map(|i| if i == fault { f[0] } else { 0.0 }).collect())
                .collect();
            let y = simulate(&g, &vec![0.0; model.nx()], &f);
            for r in &residuals(&mut *filter.build().unwrap(), &u, &y)[2..] {
                let mut index = [0.0; 2];
                spans.index_into(r, &mut index);
                // Far above rounding, also for ill-conditioned pairs of directions.
                prop_assert!(index[fault] < 1e-6, "{index:?}");
                prop_assert!(index[fault] < 0.1 * index[1 - fault], "{index:?}");
            }
        }
    }
}

/// Noise whose filter has a zero outside the unit circle is mirrored, not inverted.
#[test]
fn noise_with_a_growing_inverse_is_whitened() {
    // G_w = 1 − 1.5/(z − 0.5) = (z − 2)/(z − 0.5), of gain 2 on the circle: r = y / 2.
    let lag =
        StateSpace::new(mat![[0.5]], mat![[1.0]], mat![[1.0]], mat![[0.0]], sampled()).unwrap();
    let noise = UnknownInputs::new("w", mat![[-1.5]], mat![[1.0]]).unwrap();
    let (faults, none) = (sensors(&lag), UnknownInputs::none(&lag));
    let exposure = Exposure { faults: &faults, disturbances: &none, noise: &noise };
    let design = OptimalDesign::new(&lag, &exposure, 1.0).unwrap();
    let rw = design.form().residual_of(&noise.system(&lag).unwrap()).unwrap();
    for omega in [0.0, 1.0, 20.0, 31.0] {
        let gain = rw.frequency_response(omega).unwrap()[(0, 0)].norm();
        assert!((gain - 1.0).abs() < 1e-12, "{gain} at {omega}");
        let (_, hy) = design.form().response(omega).unwrap();
        assert!((hy[(0, 0)].norm() - 0.5).abs() < 1e-12);
    }
}

/// Two tanks with a pump and two level sensors.
fn tanks() -> StateSpace<Discrete> {
    let a = mat![[0.9, 0.05], [0.1, 0.85]];
    StateSpace::new(a, mat![[0.1], [0.0]], Mat::identity(2, 2), Mat::zeros(2, 1), sampled())
        .unwrap()
}

/// The interval holds its level on seeds that the design has never seen.
#[test]
fn fault_intervals_hold_their_level() {
    let model = tanks();
    let faults =
        UnknownInputs::none(&model).actuator(&model, 0).unwrap().sensor(&model, 1).unwrap();
    let noise = FaultNoise { process: 1e-6, output: 1e-4, drift: 4e-6 };
    let design = FaultEstimatorDesign::new(&model, &faults, &noise).unwrap();
    let entry = faults.system(&model).unwrap();
    let (runs, len) = (400, 250);
    let mut inside = [0; 2];
    for seed in 0..runs {
        let mut rng = rng(0x00c0_ffee + seed);
        let mut f = [0.5, -0.2];
        let mut x = Mat::<f64>::zeros(2, 1);
        let mut estimator = design.build().unwrap();
        let mut found = [0.0; 2];
        for k in 0..len {
            let u = [(0.1 * k as f64).sin()];
            let fault = Mat::from_fn(2, 1, |i, _| f[i]);
            let y = model.c() * &x + entry.d() * &fault;
            let y: Vec<f64> = (0..2).map(|i| y[(i, 0)] + 1e-2 * normal(&mut rng)).collect();
            let frame = fd_core::Frame::new(estimator.io(), k, &u, &y).unwrap();
            estimator.step(frame, &mut found);
            if k + 1 == len {
                for i in 0..2 {
                    let error = (found[i] - f[i]).abs();
                    inside[i] += u32::from(error < 1.96 * design.deviations()[i]);
                }
            }
            x = model.a() * &x + faer::Scale(u[0]) * model.b() + entry.b() * &fault;
            x = Mat::from_fn(2, 1, |i, _| x[(i, 0)] + 1e-3 * normal(&mut rng));
            f = f.map(|f| f + 2e-3 * normal(&mut rng));
        }
    }
    for count in inside {
        // Binomial (400, 0.95): mean 380, deviation 4.4; four of them on either side.
        assert!((363..=397).contains(&count), "{inside:?} of {runs}");
    }
}

/// The deviations are those that the covariance of the Kalman filter itself settles at, sample by
/// sample: `P⁻ = A P Aᵀ + Q`, `P = P⁻ − P⁻Cᵀ (C P⁻Cᵀ + R)⁻¹ C P⁻`.
#[test]
fn deviations_of_fault_estimates_are_those_of_the_filter() {
    let model = tanks();
    let faults =
        UnknownInputs::none(&model).actuator(&model, 0).unwrap().sensor(&model, 1).unwrap();
    let noise = FaultNoise { process: 1e-6, output: 1e-4, drift: 4e-6 };
    let design = FaultEstimatorDesign::new(&model, &faults, &noise).unwrap();
    // Levels of both tanks, fault of the pump, fault of the second sensor.
    let a = mat![
        [0.9, 0.05, 0.1, 0.0],
        [0.1, 0.85, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ];
    let c = mat![[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 1.0]];
    let q = [noise.process, noise.process, noise.drift, noise.drift];
    let mut p = Mat::<f64>::identity(4, 4);
    for _ in 0..5000 {
        let before =
            &a * &p * a.transpose() + Mat::from_fn(4, 4, |i, j| if i == j { q[i] } else { 0.0 });
        let s =
            &c * &before * c.transpose() + faer::Scale(noise.output) * Mat::<f64>::identity(2, 2);
        let determinant = s[(0, 0)] * s[(1, 1)] - s[(0, 1)] * s[(1, 0)];
        let inverse = mat![[s[(1, 1)], -s[(0, 1)]], [-s[(1, 0)], s[(0, 0)]]];
        let gain = &before * c.transpose() * inverse * faer::Scale(determinant.recip());
        p = &before - gain * &c * &before;
    }
    for (i, deviation) in design.deviations().iter().enumerate() {
        let expected = p[(2 + i, 2 + i)].sqrt();
        // The slowest mode of the filter, about √(drift/output) = 0.2 per sample, is long gone.
        assert!((deviation / expected - 1.0).abs() < 1e-9, "{deviation}, not {expected}");
    }
}

/// Two sensors that see the same state cannot be told from its actuator.
#[test]
fn an_estimator_refuses_faults_that_look_alike() {
    let model = tanks();
    let all = sensors(&model).actuator(&model, 0).unwrap();
    let noise = FaultNoise { process: 1e-6, output: 1e-4, drift: 1e-6 };
    match FaultEstimatorDesign::new(&model, &all, &noise).unwrap_err() {
        DesignError::Unobservable { re, .. } => assert!((re - 1.0).abs() < 1e-9),
        other => panic!("{other}"),
    }
}

fn adaptive(drift: f64) -> AdaptiveDesign {
    let model = tanks();
    let observer = ObserverDesign::kalman(&model, 0.05, 1.0).unwrap();
    let noise = ParameterNoise { prior: 0.5, drift, output: 1e-6, bound: 2.0 };
    let mut shifts = ParameterShift::state_rates(&model);
    shifts.extend(ParameterShift::input_gains(&model));
    // The pump acts on the first tank only: its gain and the rate of that tank differ.
    AdaptiveDesign::new(observer, shifts, noise).unwrap()
}

/// The plant whose first tank is 20 % slower and whose second is 10 % faster.
fn worn() -> StateSpace<Discrete> {
    let a = mat![[0.92, 0.04], [0.11, 0.835]];
    StateSpace::new(a, mat![[0.08], [0.0]], Mat::identity(2, 2), Mat::zeros(2, 1), sampled())
        .unwrap()
}

#[test]
fn an_adaptive_observer_learns_the_plant() {
    let design = adaptive(0.0);
    let fixed = ObserverDesign::kalman(&tanks(), 0.05, 1.0).unwrap();
    let u = signal(3, 1, 2000);
    let y = simulate(&worn(), &[0.0, 0.0], &u);
    let mut running = design.freeze::<f64>().unwrap();
    let learned = residuals(&mut running, &u, &y);
    let plain = residuals(&mut *fixed.build().unwrap(), &u, &y);
    let (start, end) = (peak(&learned[..200]), peak(&learned[1800..]));
    assert!(end < 1e-3 * peak(&plain[1800..]), "{start} {end} {}", peak(&plain[1800..]));
    let theta = running.theta();
    // The rates of both tanks; the pump's gain adds nothing to that of the first.
    for (found, expected) in theta.iter().zip([-0.2, 0.1, 0.0]) {
        assert!((found - expected).abs() < 1e-3, "{theta:?}");
    }
}

/// The weakness that the room warns of: a slowly growing fault is learned as if it were wear.
#[test]
fn an_adaptive_observer_absorbs_slow_faults() {
    let u = vec![vec![1.0]; 3000];
    let y = simulate(&tanks(), &[0.0, 0.0], &u);
    let drift: Vec<Vec<f64>> =
        (0..3000).map(|k| vec![1e-4 * f64::from((k - 1000).max(0)), 0.0]).collect();
    let y = plus(&y, &drift);
    let adaptive = residuals(&mut *adaptive(1e-6).build().unwrap(), &u, &y);
    let fixed = ObserverDesign::kalman(&tanks(), 0.05, 1.0).unwrap();
    let fixed = residuals(&mut *fixed.build().unwrap(), &u, &y);
    assert!(peak(&adaptive[2500..]) < 0.2 * peak(&fixed[2500..]));
}

#[test]
fn an_adaptive_observer_obeys_reset_and_restore() {
    let design = adaptive(1e-6);
    let u = signal(3, 1, 60);
    let y = simulate(&worn(), &[0.0, 0.0], &u);
    let frames: Vec<_> = u.iter().cloned().zip(y.iter().cloned()).collect();
    reset_and_restore(&mut design.freeze::<f64>().unwrap(), &frames);
    let narrow = |v: &[f64]| v.iter().map(|&v| f32::from_design(v)).collect::<Vec<f32>>();
    let frames: Vec<_> = frames.iter().map(|(u, y)| (narrow(u), narrow(y))).collect();
    let mut single = design.freeze::<f32>().unwrap();
    reset_and_restore(&mut single, &frames);
    assert_eq!(ResidualGenerator::<f32>::residual_len(&single), 2);

    // Before anything is learned it is its own form.
    let form = design.form().unwrap();
    let first = residuals(&mut *design.build().unwrap(), &u[..1], &y[..1]);
    let expected = simulate(form.system(), &[0.0; 2], &joined(&u[..1], &y[..1]));
    assert_eq!(first, expected);
}
