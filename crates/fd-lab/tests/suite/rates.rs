//! Stated rates of false alarms hold on plants of users: a little in the gate, all of it by `fdiag-lab rates`.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a failure here is a failed test")]

use std::path::Path;

use fd_lab::{
    compare::CompareConfig,
    rates::{Plan, detectors, measure},
};
use fdiag::spec::StartSpec;

const STATED: f64 = 0.05;

fn plant(name: &str) -> CompareConfig {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/plants").join(name);
    let text = std::fs::read_to_string(folder.join("compare.toml")).unwrap();
    let mut config: CompareConfig = text.parse().unwrap();
    config.begin_in(&folder);
    config
}

/// The rate of no detector is further from the stated one than its interval and `by`, of the plants of these seeds.
fn hold(name: &str, plan: &Plan, only: &[&str], by: [f64; 2]) {
    let mut config = plant(name);
    config.first_seed = 77_001;
    let mut detectors = detectors(STATED, config.samples_of_run());
    detectors.retain(|stated| only.is_empty() || only.contains(&stated.name));
    for rate in measure(&config, plan, &detectors).unwrap().rates {
        println!(
            "{name} {:?} {}: {} {:?}",
            plan.start,
            rate.detector,
            rate.share.text(),
            rate.refused
        );
        assert!(0 < rate.share.of, "{rate:?}");
        assert!(rate.share.low <= by[1] && by[0] <= rate.share.high, "{rate:?}");
    }
}

/// A motor with friction that its model lacks.
#[test]
fn rates_hold_on_a_motor_with_friction_from_a_fitted_bias() {
    hold("friction_motor", &plan(StartSpec::Fitted), &["n-sigma", "chi-square of 20"], [0.02, 0.1]);
}

/// The same, with a bias that is learned on line as well as a run of a minute lets it. With the start of the bias model
/// uncalibrated all runs alarmed.
#[test]
fn rates_hold_on_a_motor_with_friction_from_training() {
    let plan = Plan { tolerance: Some(1e-2), ..plan(StartSpec::Training) };
    hold("friction_motor", &plan, &["n-sigma", "chi-square of 20"], [0.02, 0.1]);
}

fn plan(start: StartSpec) -> Plan {
    let (settle_s, tolerance) = (None, None);
    Plan { plants: 2, healthy: 10, fresh: 20, learn_share: 0.7, settle_s, tolerance, start }
}
