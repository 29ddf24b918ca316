//! What a shell promises.

use std::sync::atomic::Ordering;

use faer::mat;
use fd_effect::{Candidate, Kind, NotTestable, library, offers};
use fd_gap::fit::{Horizon, Plan, Weights, null_fit};
use fd_model::{Channel, Discrete, SampleTime, StateSpace};
use fd_sim::{
    equation::Expr,
    model::{Mistake, Parameter},
    patch::Patch,
    scales::ReplayScales,
    simulate::{BlackBox, Nominal, Outcome, Shell, SimulateError, Simulator},
};
use proptest::prelude::*;

use super::pendulum::{Cause, Pendulum, THETA, TS, excitation, log, shell};

const SAMPLES: usize = 300;

fn ts(seconds: f64) -> SampleTime {
    SampleTime::new(seconds).unwrap()
}

fn run(simulator: &mut dyn Simulator, theta: &[f64], u: &[f64]) -> (Outcome, Vec<f64>) {
    let mut y = vec![0.0; u.len() / simulator.inputs().len() * simulator.outputs().len()];
    let x0 = vec![0.0; simulator.initial().len()];
    (simulator.simulate(theta, &x0, u, &mut y), y)
}

fn all(shell: &Shell, scales: &ReplayScales) -> (Vec<Candidate>, Vec<NotTestable>) {
    let (fine, not): (Vec<_>, Vec<_>) =
        offers(&library(), shell.model(), scales).into_iter().partition(Result::is_ok);
    let fine = fine.into_iter().flatten().filter(|candidate| candidate.kind == Kind::Simulation);
    (fine.collect(), not.into_iter().filter_map(Result::err).collect())
}

#[test]
fn without_effects_a_shell_gives_the_bits_of_what_is_inside() {
    let u = excitation(SAMPLES, 1.0, 1);
    for steps in [1_usize, 4] {
        let own = TS / steps as f64;
        let mut shell = shell(own).simulator(ts(TS)).unwrap();
        let mut inside = Pendulum::new(own);
        let (outcome, y) = run(&mut *shell, &THETA, &u);
        assert_eq!(outcome, Outcome::Complete);
        let each: Vec<f64> = u.iter().flat_map(|u| vec![*u; steps]).collect();
        let (_, expected) = run(&mut inside, &THETA, &each);
        let rows = expected.chunks(2).step_by(steps).flatten();
        assert_eq!(y, rows.copied().collect::<Vec<f64>>());
        assert_eq!(shell.state().len(), 2);
    }
}

#[test]
fn every_effect_is_nothing_at_zero_strength_and_something_at_its_starts() {
    let u = excitation(SAMPLES, 1.0, 2);
    let shell = shell(TS);
    let scales = shell.scales(ts(TS), &u, SAMPLES).unwrap();
    let (candidates, refused) = all(&shell, &scales);
    println!("{} candidates, {} refused", candidates.len(), refused.len());
    for refusal in &refused {
        println!("  {refusal} at {:?}", refusal.site);
    }
    let labels: Vec<&str> = candidates.iter().map(|c| c.label).collect();
    for label in ["input-delay", "coulomb-friction", "parameter-error", "sensor-lag", "end-stop"] {
        assert!(labels.contains(&label), "{label}");
    }
    let (_, nominal) = run(&mut *shell.simulator(ts(TS)).unwrap(), &THETA, &u);
    for candidate in &candidates {
        // Nothing is spliced into what only the shell knows.
        assert!(candidate.site.name().is_none_or(|name| !name.ends_with("_raw")));
        let mut simulator = shell.patched(&candidate.model, ts(TS)).unwrap();
        for (number, start) in candidate.starts.iter().enumerate() {
            let at = |of: &dyn Fn(usize) -> f64| -> Vec<f64> {
                THETA.into_iter().chain((0..start.len()).map(of)).collect()
            };
            let p = &candidate.parameters;
            let neutral = |i: usize| if p[i].is_strength { p[i].neutral } else { start[i] };
            let (_, y) = run(&mut *simulator, &at(&neutral), &u);
            let place = format!("{} ({}) at {:?}", candidate.label, candidate.law, candidate.site);
            for (y, nominal) in y.iter().zip(&nominal) {
                // Means are differences of integrals of up to 6 s: an error of 6 eps/TS = 7e-14 of
                // the torque in each of 300 steps, where the pendulum does not amplify it.
                assert!((y - nominal).abs() < 1e-10, "{place}: {y} is not {nominal}");
            }
            let (outcome, y) = run(&mut *simulator, &at(&|i| start[i]), &u);
            assert_eq!(outcome, Outcome::Complete, "{place} {start:?}");
            let moved = y.iter().zip(&nominal).map(|(y, n)| (y - n).abs()).fold(0.0, f64::max);
            assert!(0 < number || 1e-6 < moved, "{place} {start:?}: {moved}");
        }
    }
}

#[test]
fn a_port_is_a_site_with_the_mobility_of_what_is_inside() {
    let u = excitation(SAMPLES, 1.0, 3);
    let scales = shell(TS / 4.0).scales(ts(TS), &u, SAMPLES).unwrap();
    let site = &scales.sites[0];
    // A force over a sample accelerates by 1/J, less what gravity and damping take back.
    assert!((site.mobility * THETA[0] - 1.0).abs() < 0.05, "{}", site.mobility);
    assert_eq!((site.velocity.is_some(), site.position.is_some()), (true, true));
    assert!(scales.step == TS / 4.0 && scales.states.is_empty() && scales.inputs.len() == 1);

    // A port of which nobody says what it moves still takes loads.
    let blind = Shell::new("blind", Box::new(Pendulum::new(TS))).unwrap();
    let scales = blind.scales(ts(TS), &u, SAMPLES).unwrap();
    let (candidates, _) = all(&blind, &scales);
    let at_the_port = |c: &&Candidate| c.site.name() == Some("pivot");
    let labels: Vec<&str> = candidates.iter().filter(at_the_port).map(|c| c.label).collect();
    assert!(labels.contains(&"constant-load") && labels.contains(&"periodic-force"), "{labels:?}");
    assert!(!labels.contains(&"coulomb-friction"));
    // About the size of the torques that move it.
    assert!((0.1..10.0).contains(&scales.sites[0].force), "{}", scales.sites[0].force);
}

/// Without gravity and damping, motion under dry friction is known: what is pushed slides until `v²/2` has been used up,
/// and stays there under any load that friction can hold.
#[test]
fn dry_friction_at_a_port_stops_what_moves_and_holds_it() {
    const F: f64 = 0.12;
    let theta = [THETA[0], 0.0, 0.0];
    let push = |k: usize| match k {
        0..20 => 0.5,
        20..100 => 0.0,
        // What changes from step to step is held one step late; at the end of a ramp, it is held.
        100..250 => 0.99 * F * ((k as f64 - 100.0) / 100.0).min(1.0),
        _ => 0.99 * F * (1.0 - (k as f64 - 250.0) / 80.0).max(-1.0),
    };
    let u: Vec<f64> = (0..500).map(push).collect();
    for steps in [1.0, 4.0] {
        let shell = shell(TS / steps);
        let scales = shell.scales(ts(TS), &excitation(SAMPLES, 1.0, 3), SAMPLES).unwrap();
        let (candidates, _) = all(&shell, &scales);
        let is_dry = |c: &&Candidate| c.label == "coulomb-friction" && c.law == "symmetric";
        let mut simulator =
            shell.patched(&candidates.iter().find(is_dry).unwrap().model, ts(TS)).unwrap();
        let with: Vec<f64> = theta.into_iter().chain([F]).collect();
        let (_, y) = run(&mut *simulator, &with, &u);
        let rates: Vec<f64> = y.iter().skip(1).step_by(2).copied().collect();
        let (usual, fast) = ((0.5 - F) / theta[0] * 20.0 * TS, rates[20]);
        // The first step does not know yet what it will be pushed by.
        let unknown = F / theta[0] * TS / steps;
        assert!((fast - usual).abs() <= 1.001 * unknown, "{fast} {usual}");
        let stop = 20.0 * TS + fast * theta[0] / F;
        // What a force does in a step is known to some per cent: so much of the rest is left after each.
        let stopped = (0..99).find(|k| stop <= f64::from(*k) * TS).unwrap() + 8;
        assert!(stopped < 99);
        let stopped = usize::try_from(stopped).unwrap();
        for (k, rate) in rates.iter().enumerate().skip(stopped) {
            let moves = (100..208).contains(&k) || (250..418).contains(&k);
            let most = if moves { 2.0 * F / 80.0 / theta[0] * TS } else { 1e-9 * usual };
            assert!(rate.abs() < most, "{steps} {k}: {rate}");
        }
        let place = |k: usize| y[2 * k];
        let way = 0.5 * fast * fast * theta[0] / F;
        let error = (place(99) - place(20) - way).abs();
        println!("steps {steps}: slides {way}, error {error}");
        assert!(error < fast * TS / steps, "{error}");
        assert!((place(249) - place(210)).abs() < 1e-9 && (place(499) - place(420)).abs() < 1e-9);
    }
}

#[test]
fn forces_see_the_sample_before_where_a_simulator_cannot_measure() {
    let u = excitation(SAMPLES, 1.0, 4);
    let drag = |pendulum: Pendulum| {
        let shell = Shell::new("drag", Box::new(pendulum)).unwrap();
        let mut patch = Patch::of(shell.model());
        patch.add_parameter(Parameter::new("c", "N m s", 0.05));
        patch.add_force("pivot", "drag", Expr::parse("-c*rate_raw").unwrap()).unwrap();
        let mut simulator = shell.patched(&patch.finish().unwrap(), ts(TS)).unwrap();
        let [inertia, gravity, damping] = THETA;
        run(&mut *simulator, &[inertia, gravity, damping, 0.05], &u).1
    };
    let (now, before) = (drag(Pendulum::new(TS)), drag(Pendulum::new(TS).without_measuring()));
    // The same drag as part of the damping.
    let [inertia, gravity, damping] = THETA;
    let (_, inside) = run(&mut Pendulum::new(TS), &[inertia, gravity, damping + 0.05], &u);
    let distance =
        |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
    let (near, far) = (distance(&now, &inside), distance(&before, &inside));
    // Held over a step the drag is late by half of it, else by one and a half.
    assert!(near < far && far < 6.0 * near, "{near} {far}");
    assert!(far < 0.2 * distance(&inside, &run(&mut Pendulum::new(TS), &THETA, &u).1));
}

#[test]
fn what_diverges_stays_diverged_until_it_starts_again() {
    let shell = shell(TS);
    let scales = shell.scales(ts(TS), &excitation(SAMPLES, 1.0, 5), SAMPLES).unwrap();
    let (candidates, _) = all(&shell, &scales);
    let clipped = candidates.iter().find(|c| c.label == "sensor-saturation").unwrap();
    let mut simulator = shell.patched(&clipped.model, ts(TS)).unwrap();
    let theta: Vec<f64> = [-0.05, 1.2, 0.12].into_iter().chain(clipped.starts[0].clone()).collect();
    let u = excitation(SAMPLES, 1.0, 5);
    let (outcome, y) = run(&mut *simulator, &theta, &u);
    let Outcome::Diverged { sample } = outcome else { panic!("{:?}", y.last()) };
    assert!(10 < sample && sample < SAMPLES);
    let mut row = [0.0; 2];
    simulator.step(&[0.0], &[0.0], &[], &mut row);
    assert!(row.iter().all(|y| y.is_nan()));
    let fine: Vec<f64> = THETA.into_iter().chain(clipped.starts[0].clone()).collect();
    assert_eq!(run(&mut *simulator, &fine, &u).0, Outcome::Complete);
}

#[test]
fn a_run_that_starts_in_the_middle_goes_on_as_before() {
    let u = excitation(SAMPLES, 1.0, 7);
    let shell = shell(TS / 2.0);
    let scales = shell.scales(ts(TS), &u, SAMPLES).unwrap();
    let (candidates, _) = all(&shell, &scales);
    // One that knows the time, and one that pushes.
    for label in ["sensor-drift", "periodic-force"] {
        let candidate = candidates.iter().find(|c| c.label == label).unwrap();
        let theta: Vec<f64> = THETA.into_iter().chain(candidate.starts[0].clone()).collect();
        let mut simulator = shell.patched(&candidate.model, ts(TS)).unwrap();
        let mut row = [0.0; 2];
        let mut step = |simulator: &mut dyn Simulator, k: usize| {
            simulator.step(&u[k..=k], &u[k..=k], &[], &mut row);
            row
        };
        simulator.start(&theta, &[0.0; 2], 0);
        for k in 0..100 {
            step(&mut *simulator, k);
        }
        let state = simulator.state().to_vec();
        let expected: Vec<[f64; 2]> = (100..120).map(|k| step(&mut *simulator, k)).collect();
        simulator.start(&theta, &state, 100);
        for (k, expected) in (100..120).zip(expected) {
            let found = step(&mut *simulator, k);
            for (found, expected) in found.iter().zip(expected) {
                // The integral of the force starts from zero again: 2 s eps / TS.
                assert!((found - expected).abs() < 1e-11, "{label}: {found} {expected}");
            }
        }
    }
}

#[test]
fn a_fit_survives_parameters_for_which_the_black_box_diverges() {
    // The real inertia is close to the least one at which the black box runs: steps of the fit go
    // beyond it.
    let mut pendulum = Pendulum::new(TS);
    let refused = pendulum.loosen(0.03);
    let shell = Shell::new("loose", Box::new(pendulum)).unwrap();
    let record = log(Cause::Inertia(-0.4), SAMPLES, 6);
    let simulator = shell.simulator(ts(TS)).unwrap();
    let plan = Plan::new(&*simulator, &[record], Horizon::FreeRun).unwrap().into();
    let weights = Weights::white(vec![0.002, 0.01]);
    let fit = null_fit(&plan, &*simulator, &weights).unwrap();
    let tries = refused.load(Ordering::Relaxed);
    println!("{tries} tries beyond; parameters {:?}", fit.problem.nuisance_values(&fit.minimum.z));
    assert!(0 < tries);
    let per_value = fit.minimum.cost / plan.measured() as f64;
    assert!(per_value < 1.2, "{per_value}");
}

#[test]
fn names_rates_and_models_that_do_not_fit() {
    let shell = shell(TS);
    assert_eq!(shell.model().inputs[0].name, "motor_torque");
    assert_eq!(shell.inside().inputs()[0].name, "motor torque");
    let refused = shell.simulator(ts(0.03)).unwrap_err();
    assert_eq!(refused, SimulateError::Rate { own: TS, ts: 0.03 });
    let other = Shell::new("other", Box::new(first_order(0.5))).unwrap();
    let refused = shell.patched(other.model(), ts(TS)).unwrap_err();
    assert!(matches!(refused, SimulateError::NotThisShell { .. }), "{refused}");
    let unknown = shell.clone().with_motion("pivot", Some("angl"), None).unwrap_err();
    let Mistake::UnknownName { nearest, .. } = &*unknown.mistake else { panic!("{unknown}") };
    assert!(nearest.contains(&"angle".to_owned()), "{nearest:?}");
    // A parameter that an effect lets depend on an input cannot be handed on.
    let mut patch = Patch::of(shell.model());
    patch.wrap_parameter("J", "real", Expr::parse("J*(1 + motor_torque)").unwrap()).unwrap();
    let refused = shell.patched(&patch.finish().unwrap(), ts(TS)).unwrap_err();
    assert!(matches!(refused, SimulateError::Compile(_)), "{refused}");
}

/// `x' = a x + (1 - a) u`, `y = x`, one step per 0.1 s.
fn first_order(a: f64) -> BlackBox {
    let domain = Discrete { ts: ts(0.1) };
    let one = |value: f64| mat![[value]];
    let system = StateSpace::new(one(a), one(1.0 - a), one(1.0), one(0.0), domain).unwrap();
    BlackBox::discrete(&system, vec![Channel::new("u", "V")], vec![Channel::new("y", "V")]).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(24)
    })]

    /// A factor in front of the input of a linear plant is a factor behind its output.
    #[test]
    fn wrapping_commutes_with_a_gain(
        a in -0.9..0.9, gain in -3.0..3.0, u in prop::collection::vec(-1.0..1.0, 50),
    ) {
        let shell = Shell::new("linear", Box::new(first_order(a))).unwrap();
        let wrap = |at_input: bool| {
            let mut patch = Patch::of(shell.model());
            patch.add_parameter(Parameter::new("k", "1", gain));
            if at_input {
                patch.wrap_input("u", "seen", Expr::parse("k*u").unwrap()).unwrap();
            } else {
                patch.wrap_output("y", "shown", Expr::parse("k*shown").unwrap()).unwrap();
            }
            let mut simulator = shell.patched(&patch.finish().unwrap(), ts(0.1)).unwrap();
            run(&mut *simulator, &[gain], &u).1
        };
        for (before, after) in wrap(true).iter().zip(wrap(false)) {
            // A few roundings per step, forgotten as 0.9^k: 10 * 3 eps * |k|.
            prop_assert!((before - after).abs() < 1e-13);
        }
    }
}
