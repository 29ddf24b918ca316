//! Laws of effects against exact solutions and against finer integration steps.

use fd_effect::{Candidate, Kind, library, offers};
use fd_sim::{
    equation::Expr,
    model::{Model, Output},
    simulate::{EquationSimulator, Simulator},
};

use crate::cases::{Case, PLANTS, effect, name};

/// An integrator of what arrives, and a sensor of time.
fn bench() -> Case {
    let text = r#"
version = 1
kind = "equations"
name = "bench"
sample_time = 0.1
step = 0.05
inputs = { u = { unit = "1" } }
[states]
x = { unit = "s", initial = 0.0, derivative = "u" }
ramp = { unit = "s", initial = 0.0, derivative = "1" }
[outputs]
sum = { unit = "s", value = "x" }
clock = { unit = "s", value = "ramp" }
"#;
    let mut case = Case::of(text.parse::<Model>().unwrap(), 60);
    // A step at 0.1 s: the integral of its response is known.
    case.u = (0..60).map(|k| if k == 0 { 0.0 } else { 1.0 }).collect();
    case
}

fn candidate(case: &Case, label: &str, law: &str, site: &str) -> Candidate {
    let all = case.simulated();
    let is_it = |c: &&Candidate| c.label == label && c.law == law && c.site.name() == Some(site);
    all.iter().find(is_it).unwrap().clone()
}

/// Whether the output is a control signal, which is held between samples.
pub(crate) fn is_held(candidate: &Candidate) -> bool {
    candidate.site.each().iter().any(|site| site.name() == Some("voltage"))
}

/// Output `channel` of the bench, against `exact` of the time.
fn check(case: &Case, effect: (&str, &str, &str), phi: &[f64], exact: impl Fn(f64) -> f64) {
    let (label, law, site) = effect;
    let channel = usize::from(site == "clock");
    let (_, y) = case.apply(&candidate(case, label, law, site), phi);
    for (k, row) in y.chunks(2).enumerate() {
        let t = 0.1 * k as f64;
        // Some hundred steps, each with a rounding error of an ulp of 6.
        let expected = exact(t);
        assert!((row[channel] - expected).abs() < 1e-12, "{label}, t = {t}: {row:?}, {expected}");
    }
}

#[test]
fn actuator_dynamics_are_exact_for_held_inputs() {
    let case = bench();
    for lag in [0.013, 0.2, 3.0] {
        check(&case, ("input-lag", "order-1", "u"), &[lag], |t| {
            let t = (t - 0.1).max(0.0);
            t - lag * (1.0 - (-t / lag).exp())
        });
        for ratio in [0.0, 0.4, 0.95] {
            let second = ratio * lag;
            check(&case, ("input-lag", "order-2", "u"), &[lag, ratio], |t| {
                let t = (t - 0.1).max(0.0);
                let part = |lag: f64| lag * lag * (1.0 - (-t / lag.max(1e-9)).exp());
                t - (part(lag) - part(second)) / (lag - second)
            });
        }
    }
    for delay in [0.0, 0.031, 0.1, 1.234] {
        check(&case, ("input-delay", "pure", "u"), &[delay], |t| (t - 0.1 - delay).max(0.0));
    }
    for inverse in [0.02, 0.5, 3.0] {
        check(&case, ("input-rate-limit", "symmetric", "u"), &[inverse], |t| {
            let t = (t - 0.1).max(0.0);
            if t < inverse { t * t / (2.0 * inverse) } else { t - inverse / 2.0 }
        });
        let asymmetric = ("input-rate-limit", "asymmetric", "u");
        check(&case, asymmetric, &[inverse, 0.5], |t| {
            let (t, inverse) = ((t - 0.1).max(0.0), 1.5 * inverse);
            if t < inverse { t * t / (2.0 * inverse) } else { t - inverse / 2.0 }
        });
    }
}

#[test]
fn sensor_dynamics_are_exact_for_ramps() {
    let case = bench();
    for lag in [0.013, 0.2, 3.0] {
        check(&case, ("sensor-lag", "order-1", "clock"), &[lag], |t| {
            t - lag * (1.0 - (-t / lag).exp())
        });
        for ratio in [0.0, 0.4, 0.95] {
            let second = ratio * lag;
            check(&case, ("sensor-lag", "order-2", "clock"), &[lag, ratio], |t| {
                let part = |lag: f64| lag * lag * (1.0 - (-t / lag.max(1e-9)).exp());
                t - (part(lag) - part(second)) / (lag - second)
            });
        }
    }
    for delay in [0.05, 0.4] {
        // The past is interpolated where it began to move, so only whole steps are exact there.
        check(&case, ("sensor-delay", "pure", "clock"), &[delay], |t| (t - delay).max(0.0));
    }
}

#[test]
fn actuator_curves_are_as_their_names_say() {
    let mut case = bench();
    // Held for a sample, the integral is the sum of what arrived.
    case.u = (0..60).map(|k| 2.0 * (0.37 * f64::from(k)).sin()).collect();
    let u = case.u.clone();
    let arrives = |label: &str, law: &str, phi: &[f64], curve: &mut dyn FnMut(f64) -> f64| {
        let (_, y) = case.apply(&candidate(&case, label, law, "u"), phi);
        let mut sum = 0.0;
        for (k, row) in y.chunks(2).enumerate() {
            assert!((row[0] - sum).abs() < 1e-12, "{label} ({law}) {k}: {row:?}, {sum}");
            sum += 0.1 * curve(u[k]);
        }
    };
    arrives("input-gain", "asymmetric", &[0.1, 0.2], &mut |u| {
        if u > 0.0 { 1.3 * u } else { 0.9 * u }
    });
    arrives("input-dead-zone", "asymmetric", &[0.4, 0.5], &mut |u| {
        if u > 0.6 { u - 0.6 } else { (u + 0.2).min(0.0) }
    });
    arrives("input-saturation", "hard", &[0.8], &mut |u| u.clamp(-1.25, 1.25));
    arrives("input-saturation", "upper", &[0.8], &mut |u| u.min(1.25));
    arrives("input-saturation", "lower", &[0.8], &mut |u| u.max(-1.25));
    arrives("input-saturation", "asymmetric", &[0.8, 0.25], &mut |u| u.clamp(-1.0 / 0.6, 1.0));
    arrives("input-saturation", "tanh", &[0.8], &mut |u| (0.8 * u).tanh() / 0.8);
    arrives("input-saturation", "soft", &[0.8, 2.0], &mut |u| u / (0.64 * u * u + 1.0).sqrt());
    arrives("input-quantisation", "round", &[0.25], &mut |u| (4.0 * u).round() / 4.0);
    arrives("input-quantisation", "towards-zero", &[0.25], &mut |u| (4.0 * u).trunc() / 4.0);
    arrives("input-quantisation", "downwards", &[0.25], &mut |u| (4.0 * u).floor() / 4.0);
    let mut played = 0.0;
    arrives("input-backlash", "play", &[0.3], &mut |u| {
        played = f64::clamp(played, u - 0.3, u + 0.3);
        played
    });
}

#[test]
fn play_behind_the_plant_is_taken_up_first() {
    let mut case = bench();
    // Up for 3 s, then down: the integral turns at 3 s.
    case.u = (0..60).map(|k| if k < 30 { 1.0 } else { -1.0 }).collect();
    let (_, y) = case.apply(&candidate(&case, "sensor-backlash", "play", "sum"), &[0.4]);
    for (k, row) in y.chunks(2).enumerate() {
        let t = 0.1 * k as f64;
        let x = if t < 3.0 { t } else { 6.0 - t };
        let shown = if t < 3.0 { (x - 0.4).max(0.0) } else { 2.6_f64.min(x + 0.4) };
        // Some hundred steps, each with a rounding error of an ulp of 3.
        assert!((row[0] - shown).abs() < 1e-12, "t = {t}: {row:?}, {shown}");
    }
}

#[test]
fn sensor_limits_are_as_their_names_say() {
    let case = bench();
    let shows = |law: &str, phi: &[f64], curve: &dyn Fn(f64) -> f64| {
        check(&case, ("sensor-saturation", law, "clock"), phi, curve);
    };
    // The nominal clock goes from 0 to 5.9 s.
    shows("both", &[0.5], &|t| t.clamp(0.95, 4.95));
    shows("upper", &[0.5], &|t| t.min(4.95));
    shows("lower", &[0.5], &|t| t.max(0.95));
    shows("between-limits", &[0.5, 3.5], &|t| t.clamp(1.5, 5.5));
    shows("rounded", &[0.5, 3.5, 2.0], &|t| {
        let d = t - 3.5;
        3.5 + d / (1.0 + 0.25 * d * d).sqrt()
    });
}

/// A puck without friction, which flies at 1 m/s from one end of a range of 2 m to the other.
fn puck() -> Case {
    let text = r#"
version = 1
kind = "equations"
name = "puck"
sample_time = 0.01
step = 0.001
inputs = { push = { unit = "N" } }
[states]
x = { unit = "m", initial = 0.0, derivative = "v" }
v = { unit = "m/s", initial = 0.0, derivative = "push" }
[outputs]
position = { unit = "m", value = "x" }
speed = { unit = "m/s", value = "v" }
[sites]
ice = { unit = "N", enters = { v = "1" }, position = "x", velocity = "v" }
"#;
    let u = (0..210).map(|k| if k < 10 { 10.0 } else { 0.0 }).collect();
    Case::with_input(text.parse::<Model>().unwrap(), u, 210)
}

#[test]
fn a_load_comes_when_it_is_said_to() {
    let case = puck();
    let late = candidate(&case, "constant-load", "applied-late", "ice");
    let (_, nominal) = case.apply(&late, &[0.0, 0.5]);
    for since in [0.0, 0.25, 0.5004, 1.7] {
        let (_, y) = case.apply(&late, &[0.3, since]);
        for (k, (row, without)) in y.chunks(2).zip(nominal.chunks(2)).enumerate() {
            let t = 0.01 * k as f64;
            let expected = 0.3 * (t - since).max(0.0);
            // It grows within the integration step of 1 ms before.
            assert!((row[1] - without[1] - expected).abs() < 0.3e-3, "{since}, {t}: {row:?}");
        }
    }
}

#[test]
fn a_load_that_is_put_on_slowly_grows_in_a_line() {
    let case = puck();
    let slow = candidate(&case, "constant-load", "put-on-slowly", "ice");
    let (_, nominal) = case.apply(&slow, &[0.0, 0.5, 0.8]);
    let (_, y) = case.apply(&slow, &[0.3, 0.5, 0.8]);
    for (k, (row, without)) in y.chunks(2).zip(nominal.chunks(2)).enumerate() {
        let t = 0.01 * k as f64;
        let grown = (t - 0.5).clamp(0.0, 0.8);
        let expected = 0.3 * (grown * grown / 1.6 + (t - 1.3).max(0.0));
        // Straight lines but for two corners within a step of 1 ms.
        assert!((row[1] - without[1] - expected).abs() <= 1e-6, "{t}: {row:?}");
    }
}

#[test]
fn stops_throw_back() {
    let case = puck();
    let (_, free) = case.apply(&candidate(&case, "end-stop", "both", "ice"), &[0.0, 100.0]);
    let far = free[2 * 209];
    assert!((1.9..2.1).contains(&far), "{far}");
    // The stops are at -2.5 m and 1.5 m, not evenly around the nominal range.
    let last = |law: &str, phi: &[f64]| {
        let (_, y) = case.apply(&candidate(&case, "end-stop", law, "ice"), phi);
        [y[2 * 209], y[2 * 209 + 1]]
    };
    let at = 1.5;
    let [x, v] = last("between-stops", &[0.5, 2000.0, -0.5]);
    // Runge-Kutta loses little of the energy; within is half a period of the contact.
    assert!((v + 1.0).abs() < 1e-3, "{v}");
    let contact = std::f64::consts::PI / f64::sqrt(2000.0);
    let expected = at - (free[2 * 209] - at - contact);
    assert!((x - expected).abs() < 2e-3, "{x} {expected}");
    // Hunt and Crossley: a restitution of 1 - 2 b v/3 for small b.
    let [_, slower] = last("damped", &[0.5, 2000.0, -0.5, 0.15]);
    assert!((slower + 0.905).abs() < 0.01, "{slower}");
    // Without damping both are one law, up to rounding.
    let [same, _] = last("damped", &[0.5, 2000.0, -0.5, 0.0]);
    assert!((same - x).abs() < 1e-9, "{same} {x}");
}

#[test]
fn friction_and_springs_work_against_the_motion_at_every_site() {
    let mut checked = 0;
    for plant in PLANTS {
        let case = Case::new(plant, 300);
        let work = |candidate: &Candidate, phi: &[f64]| {
            // The mean power of the force, from a model that shows it.
            let (sites, i) = (&case.scales.sites, &candidate.site);
            let site = sites.iter().find(|site| Some(site.name.as_str()) == i.name()).unwrap();
            let mut draft = candidate.model.clone().into_draft();
            let ny = draft.outputs.len();
            let force = draft.definitions.last().unwrap().name.clone();
            let (velocity, _) = site.velocity.clone().unwrap();
            for (name, value) in [("shown_force", Expr::name(force)), ("shown_velocity", velocity)]
            {
                let (name, unit) = (name.to_owned(), "1".to_owned());
                draft.outputs.push(Output::new(name, unit, value));
            }
            let model = Model::try_from(draft).unwrap();
            let mut theta = case.model.nominal();
            theta.extend(phi);
            let (_, y) = case.run(&model, &theta);
            let power = y.chunks(ny + 2).map(|row| row[ny] * row[ny + 1]);
            let usual = 300.0 * site.force * site.velocity.as_ref().unwrap().1.std;
            site.mobility.signum() * power.sum::<f64>() / usual
        };
        for candidate in case.simulated() {
            // What is alike at several places does there what it does at each (`alike`).
            if effect(&candidate).dissipates() && candidate.site.each().len() == 1 {
                for start in &candidate.starts {
                    let power = work(&candidate, start);
                    // What sticks all the time does no work, up to rounding.
                    assert!(power < 1e-12, "{plant}: {} {start:?}: {power}", name(&candidate));
                    checked += usize::from(power < -1e-3);
                }
            }
        }
    }
    assert!(checked > 100, "{checked}");
}

#[test]
fn a_finer_step_changes_little() {
    for plant in PLANTS {
        let case = Case::new(plant, 300);
        for candidate in case.simulated() {
            // A lag of a held signal: how much of a jump it shows in the very sample of the jump is
            // a matter of the step.
            if candidate.label == "sensor-lag" && is_held(&candidate) {
                continue;
            }
            let plain = EquationSimulator::<f64>::new(&candidate.model).unwrap();
            for start in &candidate.starts {
                let mut theta = case.model.nominal();
                theta.extend(start);
                let run = |factor| {
                    let mut simulator = plain.refined(factor);
                    let mut y = vec![0.0; case.samples * candidate.model.outputs.len()];
                    let x0 = candidate.model.initial();
                    Simulator::simulate(&mut simulator, &theta, &x0, &case.u, &mut y);
                    y
                };
                let distance = case.distance(&run(1), &run(8));
                // What swings by two radians in a step is seen by its ends only; finer steps help with their square. From rest the
                // largest jump of all falls into the middle of a step, of which the plant sees the mean.
                let is_rough =
                    candidate.label == "elastic-transmission" || candidate.law == "pure-from-rest";
                let most = if is_rough { 0.15 } else { 0.05 };
                assert!(distance < most, "{plant}: {} {start:?}: {distance}", name(&candidate));
            }
        }
    }
}

#[test]
fn effects_go_on_top_of_effects() {
    let case = Case::new("pendulum", 100);
    let first = candidate(&case, "coulomb-friction", "stribeck", "joint");
    let mut theta = case.model.nominal();
    theta.extend(&first.starts[0]);
    // With the step of the study, and with a shorter one that the first was found to need.
    for part in [1.0, 0.25] {
        let mut draft = first.model.clone().into_draft();
        draft.step = Some(part * case.scales.step);
        let model = Model::try_from(draft).unwrap();
        let expected = case.run(&model, &theta).1;
        let second = offers(&library(), &model, &case.scales);
        let second: Vec<Candidate> = second.into_iter().filter_map(Result::ok).collect();
        assert!(case.simulated().len() <= second.len());
        for candidate in second.iter().filter(|c| c.kind == Kind::Simulation) {
            let mut theta = theta.clone();
            theta.extend(candidate.parameters.iter().map(|p| p.neutral));
            assert_eq!(case.run(&candidate.model, &theta).1, expected, "{}", name(candidate));
        }
    }
}

#[test]
fn a_refined_grid_is_one_grid() {
    let mut case = Case::new("two_mass_drive", 100);
    case.scales = case.scales.refined(4);
    let mut draft = case.model.clone().into_draft();
    draft.step = Some(case.scales.step);
    let expected = case.run(&Model::try_from(draft).unwrap(), &case.model.nominal()).1;
    for candidate in case.simulated() {
        assert_eq!(candidate.model.step, Some(case.scales.step));
        let y = case.run(&candidate.model, &candidate.model.nominal()).1;
        assert_eq!(y, expected, "{}", name(&candidate));
    }
}
