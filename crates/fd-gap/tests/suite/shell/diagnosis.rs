//! The cause that a black-box pendulum lacks is named.

use std::time::Instant;

use fd_effect::{EverySite, library};
use fd_gap::diagnose::{Case, Diagnosis, Settings, Verdict, diagnose};
use fd_model::SampleTime;
use fd_sim::simulate::{Nominal, Shell};

use super::pendulum::{Cause, TS, log, shell};

const SAMPLES: usize = 600;

fn run(shell: &Shell, cause: Cause, seed: u64) -> Diagnosis {
    let begin = Instant::now();
    let record = log(cause, SAMPLES, seed);
    let ts = SampleTime::new(TS).unwrap();
    let u: Vec<f64> = record.samples().flat_map(|(u, _)| u.to_vec()).collect();
    let scales = shell.scales(ts, &u, SAMPLES).unwrap();
    // Maps and observations are not what is tested here, and would take their time.
    let suspects = EverySite::new(library(), shell.model(), scales).without(&["map".to_owned()]);
    let logs = [record];
    let case = Case { nominal: shell, suspects: &suspects, logs: &logs, held_out: &[] };
    let diagnosis = diagnose(&case, &Settings::default(), &()).unwrap();
    println!("{cause:?}: {:?} after {:?}", diagnosis.verdict, begin.elapsed());
    println!("  no gap {:.4}, {} simulations", diagnosis.no_gap, diagnosis.simulations);
    for cause in diagnosis.causes.iter().take(4) {
        println!(
            "  {} at {:?} p {:.4} gap {:.3} {:?}",
            cause.label,
            cause.site.name(),
            cause.probability,
            cause.gap,
            cause.parameters.iter().map(|p| (p.value, p.standard_error)).collect::<Vec<_>>()
        );
    }
    diagnosis
}

/// Names the cause, alone and sure, with the right strength.
fn assert_named(shell: &Shell, cause: Cause, label: &str, site: &str, strength: f64, within: f64) {
    let diagnosis = run(shell, cause, 11);
    let first = &diagnosis.causes[0];
    assert_eq!((first.label, first.site.name()), (label, Some(site)));
    assert_eq!(diagnosis.verdict, Verdict::Cause);
    // A law that is not quite that of the black box leaves more than noise, and that is a witness as well.
    let sure = if within == 0.0 { 0.9 } else { 0.7 };
    assert!(sure < first.probability, "{}", first.probability);
    let found = &first.parameters[0];
    let error = (found.value - strength).abs();
    // Three standard errors, and what the black box makes of held means.
    assert!(error < 3.0 * found.standard_error + within * strength.abs(), "{found:?}");
}

#[test]
fn dead_zone_of_the_motor() {
    assert_named(&shell(TS), Cause::DeadZone(0.15), "input-dead-zone", "motor_torque", 0.15, 0.0);
}

#[test]
fn delay_of_the_motor_by_a_part_of_a_sample() {
    // 96 of 40 steps per sample.
    assert_named(&shell(TS), Cause::Delay(96), "input-delay", "motor_torque", 2.4 * TS, 0.0);
}

#[test]
fn lag_of_the_motor() {
    assert_named(&shell(TS), Cause::Lag(0.08), "input-lag", "motor_torque", 0.08, 0.0);
}

#[test]
fn rate_limit_of_the_motor() {
    let inverse = 1.0 / 5.0;
    let cause = Cause::RateLimit(5.0);
    assert_named(&shell(TS), cause, "input-rate-limit", "motor_torque", inverse, 0.0);
}

#[test]
fn bias_of_the_angle() {
    assert_named(&shell(TS), Cause::AngleBias(0.02), "sensor-bias", "angle", 0.02, 0.0);
}

#[test]
fn dry_friction_through_the_port() {
    let cause = Cause::Coulomb(0.12);
    assert_named(&shell(TS / 4.0), cause, "coulomb-friction", "pivot", 0.12, 0.05);
}

#[test]
fn wrong_inertia() {
    // The nominal inertia is 3 % off, and a fit may move it by 6 %.
    assert_named(&shell(TS), Cause::Inertia(0.3), "parameter-error", "J", 0.3, 0.3);
}

#[test]
fn nothing_is_nothing() {
    let diagnosis = run(&shell(TS), Cause::Nothing, 12);
    assert_eq!(diagnosis.verdict, Verdict::NoGap);
}
