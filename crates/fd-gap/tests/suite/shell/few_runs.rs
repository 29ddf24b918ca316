//! Few runs of a black box say what many say.

use std::sync::atomic::Ordering;

use fd_effect::{EverySite, library};
use fd_gap::{
    diagnose::{Case, Diagnosis, Settings, Verdict},
    few_runs::{Effort, with_few_runs},
};
use fd_model::{Record, SampleTime};
use fd_sim::simulate::Nominal;

use super::pendulum::{Cause, Pendulum, TS, log, shell_of};

const SAMPLES: usize = 600;
/// As many runs as a diagnosis may make of a simulator that remembers none of them; many are several thousand.
const FEW: f64 = 600.0;

/// The same where limits are tried on the simulator.
const SOME: f64 = 5000.0;

fn run(pendulum: Pendulum, cause: Cause, effort: Effort) -> (Diagnosis, f64) {
    run_on(pendulum, cause, log(cause, SAMPLES, 11), effort)
}

fn run_on(pendulum: Pendulum, cause: Cause, record: Record, effort: Effort) -> (Diagnosis, f64) {
    let (steps, own) = (pendulum.steps(), pendulum.ts);
    let shell = shell_of(pendulum);
    let ts = SampleTime::new(TS).unwrap();
    let u: Vec<f64> = record.samples().flat_map(|(u, _)| u.to_vec()).collect();
    let samples = record.len();
    let scales = shell.scales(ts, &u, samples).unwrap();
    let forces: Vec<f64> = scales.sites.iter().map(|site| site.force).collect();
    let suspects = EverySite::new(library(), shell.model(), scales);
    let logs = [record];
    let case = Case { nominal: &shell, suspects: &suspects, logs: &logs, held_out: &[] };
    let few = with_few_runs(&shell, &forces, &case, &Settings::default(), effort, &());
    let few = few.unwrap().unwrap();
    let runs = steps.load(Ordering::Relaxed) as f64 * own / TS / samples as f64;
    let (foretold, made_of) = (few.explains, few.runs);
    println!(
        "{cause:?}: {:?}, {runs:.0} runs, {foretold:.4} foretold by {made_of}",
        few.diagnosis.verdict
    );
    // One run as it is, one to check, two states, an input, a port and three parameters; where the parameters move far,
    // all that again along the refitted run, and where there is a cause, along the run with it.
    assert!([9, 18, 27].contains(&made_of), "{made_of}");
    assert!(runs < if few.limits { SOME } else { FEW }, "{runs}");
    (few.diagnosis, runs)
}

/// Names the cause as many runs do.
fn assert_named(pendulum: Pendulum, cause: Cause, named: [&str; 2], strength: f64, within: f64) {
    let (diagnosis, _) = run(pendulum, cause, Effort::default());
    let first = &diagnosis.causes[0];
    assert_eq!((first.label, first.site.name()), (named[0], Some(named[1])));
    assert_eq!(diagnosis.verdict, Verdict::Cause);
    let found = &first.parameters[0];
    let error = (found.value - strength).abs();
    // Three standard errors, and what the black box makes of held means.
    assert!(error < 3.0 * found.standard_error + within * strength.abs(), "{found:?}");
}

/// With states to be seen and without.
fn both(ts: f64) -> [Pendulum; 2] {
    [Pendulum::new(ts), Pendulum::new(ts).in_the_dark()]
}

#[test]
fn dead_zone_of_the_motor() {
    let named = ["input-dead-zone", "motor_torque"];
    for pendulum in both(TS) {
        assert_named(pendulum, Cause::DeadZone(0.15), named, 0.15, 0.0);
    }
}

#[test]
fn delay_of_the_motor() {
    let named = ["input-delay", "motor_torque"];
    for pendulum in both(TS) {
        assert_named(pendulum, Cause::Delay(96), named, 2.4 * TS, 0.0);
    }
}

#[test]
fn bias_of_the_angle() {
    let named = ["sensor-bias", "angle"];
    for pendulum in both(TS) {
        assert_named(pendulum, Cause::AngleBias(0.02), named, 0.02, 0.0);
    }
}

#[test]
fn dry_friction_through_the_port() {
    let (cause, named) = (Cause::Coulomb(0.12), ["coulomb-friction", "pivot"]);
    for pendulum in both(TS / 4.0) {
        assert_named(pendulum, cause, named, 0.12, 0.05);
    }
}

#[test]
fn wrong_inertia() {
    let (cause, named) = (Cause::Inertia(0.3), ["parameter-error", "J"]);
    for pendulum in both(TS) {
        assert_named(pendulum, cause, named, 0.3, 0.3);
    }
}

/// Where it begins is free then, also where nothing shows how far the states move.
#[test]
fn dead_zone_in_a_log_that_begins_in_motion() {
    let cause = Cause::DeadZone(0.15);
    let record = log(cause, SAMPLES + 150, 11).slice(150, SAMPLES + 150).as_its_own_run();
    for pendulum in both(TS) {
        let (diagnosis, _) = run_on(pendulum, cause, record.clone(), Effort::default());
        let first = &diagnosis.causes[0];
        let (label, site) = (first.label, first.site.name());
        assert_eq!((label, site), ("input-dead-zone", Some("motor_torque")));
        let found = &first.parameters[0];
        assert!((found.value - 0.15).abs() < 3.0 * found.standard_error, "{found:?}");
    }
}

/// A command that is cut off has no slope, so that no linear model knows of a nearer limit.
#[test]
fn a_limit_that_is_nearer_than_that_of_the_simulator() {
    let (cause, pendulum) = (Cause::Limit(0.25), || Pendulum::new(TS).with_strongest(0.4));
    let (diagnosis, _) = run(pendulum(), cause, Effort::default());
    let first = &diagnosis.causes[0];
    assert_eq!(diagnosis.verdict, Verdict::Cause);
    assert_eq!((first.label, first.site.name()), ("input-saturation", Some("motor_torque")));
    let found = &first.parameters[0];
    assert!((found.value - 4.0).abs() < 4.0 * found.standard_error, "{found:?}");
    let effort = Effort { limits: false, ..Effort::default() };
    assert_eq!(run(pendulum(), cause, effort).0.verdict, Verdict::NoneOfThese);
}

#[test]
fn nothing_is_nothing() {
    let (diagnosis, _) = run(Pendulum::new(TS), Cause::Nothing, Effort::default());
    assert_eq!(diagnosis.verdict, Verdict::NoGap);
}

#[test]
fn less_effort_costs_fewer_runs_and_finds_the_same() {
    let cause = Cause::DeadZone(0.15);
    let (all, many) = run(Pendulum::new(TS), cause, Effort::default());
    let (some, few) = run(Pendulum::new(TS), cause, Effort { causes: 2, pairs: 0, limits: false });
    assert!(few < many, "{few} {many}");
    assert_eq!(all.causes[0].label, some.causes[0].label);
    assert!(some.causes.len() < all.causes.len());
}
