//! Compensators whose bias model was fitted beforehand, in both modes, and plans from a spec.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use crate::support::{Arx, PAPER_THETA, bits, kinds, paper_input, push, response, run};
use fd_compensate::residual_compensation::{
    CompensationPlan, FixedParameters, Mode, PreFitted, RangePolicy, ResidualCompensator,
};
use fd_core::{
    EventKind,
    stage::{Phase, Stage},
};

/// A bias of moderate speed, poles 0.8 and 0.5.
const THETA: [f64; 5] = [-1.3, 0.4, 0.05, -0.02, 0.01];

#[test]
fn opening_the_switch_causes_no_transient() {
    // With the true parameters, μ̂ continues the measured bias to rounding from the first sample.
    let u = paper_input(1200);
    let r = response::<2>(&THETA, &u);
    let fit = PreFitted {
        theta: THETA.to_vec(),
        input_low: vec![0.0],
        input_high: vec![2.0],
        residual_peak: 1.0,
        filling: 2,
    };
    let fixed = FixedParameters::new(1, 1, &THETA);
    let plan = CompensationPlan::default();
    let mut compensator =
        ResidualCompensator::pre_fitted(fixed, Arx::<f64, 2>::new(), fit, &plan).unwrap();
    // Start in the middle of the record, far from rest.
    let (star, log) = run(&mut compensator, &u[400..], &r[400..]);
    assert!(log.is_empty(), "{log:?}");
    let peak = r.iter().fold(0.0_f64, |p, v| p.max(v.abs()));
    // Two histories of u are wanting for b₂; from sample 2 on, rounding: 5 terms, gain 1/A(1) = 10.
    assert!(star[2..].iter().all(|v| v.abs() < 1e-13 * peak), "{:?}", &star[..6]);
}

#[test]
fn one_step_mode_lets_a_fault_leak_and_keeps_a_of_one() {
    let n = 6000;
    let u = paper_input(n);
    let healthy = response::<2>(&PAPER_THETA, &u);
    let fault_at = 1000;
    let faulty: Vec<f64> =
        healthy.iter().enumerate().map(|(k, r)| if k < fault_at { *r } else { r + 1.0 }).collect();
    let last = |mode| {
        let plan = CompensationPlan { mode, ..CompensationPlan::default() };
        let fit = PreFitted {
            theta: PAPER_THETA.to_vec(),
            input_low: vec![0.0],
            input_high: vec![2.0],
            residual_peak: 1.0,
            filling: 0,
        };
        let fixed = FixedParameters::new(1, 1, &PAPER_THETA);
        let mut compensator =
            ResidualCompensator::pre_fitted(fixed, Arx::<f64, 2>::new(), fit, &plan).unwrap();
        run(&mut compensator, &u, &faulty).0
    };
    let (simulated, one_step) = (last(Mode::Simulation), last(Mode::OneStep));
    let a_of_one = 1.0 + PAPER_THETA[0] + PAPER_THETA[1];
    // A(z) f: 1 at once, 1 + a₁ next, A(1) for good. Rounding of five terms of size 1.
    assert!((one_step[fault_at] - 1.0).abs() < 1e-14);
    assert!((one_step[fault_at + 1] - (1.0 + PAPER_THETA[0])).abs() < 1e-14);
    assert!(one_step[fault_at + 2..].iter().all(|v| (v - a_of_one).abs() < 1e-14));
    // Simulation keeps all of it; rounding is amplified by at most 1/A(1) = 479.
    assert!(simulated[fault_at..].iter().all(|v| (v - 1.0).abs() < 1e-11));
    assert!((a_of_one - 0.002_087).abs() < 1e-12);
}

#[test]
fn an_unstable_model_is_found_out_and_training_starts_again() {
    let fit = PreFitted {
        theta: vec![-1.1, 0.0, 0.1, 0.0, 0.0],
        input_low: vec![0.0],
        input_high: vec![2.0],
        residual_peak: 1.0,
        filling: 0,
    };
    let fixed = FixedParameters::new(1, 1, &fit.theta);
    let mut compensator = ResidualCompensator::pre_fitted(
        fixed,
        Arx::<f64, 2>::new(),
        fit,
        &CompensationPlan::default(),
    )
    .unwrap();
    let u = paper_input(300);
    let r = vec![0.1; 300];
    let (star, log) = run(&mut compensator, &u, &r);
    assert_eq!(kinds(&log)[..2], [EventKind::BiasModelRejected, EventKind::TrainingStarted]);
    assert!(star.iter().all(|v| v.is_finite()));
}

#[test]
fn a_pre_fitted_compensator_resets_to_its_fit() {
    let fit = PreFitted {
        theta: THETA.to_vec(),
        input_low: vec![0.0],
        input_high: vec![2.0],
        residual_peak: 1.0,
        filling: 3,
    };
    let u = paper_input(100);
    let r = response::<2>(&THETA, &u);
    let identifier = FixedParameters::new(1, 1, &THETA);
    let plan = CompensationPlan::default();
    let mut one =
        ResidualCompensator::pre_fitted(identifier, Arx::<f64, 2>::new(), fit, &plan).unwrap();
    assert_eq!(push(&mut one.clone(), 0, u[0], r[0]).1, Phase::Training { samples: 0 });
    let (first, _) = run(&mut one, &u, &r);
    one.reset();
    let (again, _) = run(&mut one, &u, &r);
    assert_eq!(bits(&first), bits(&again));
}

#[test]
fn a_plan_reads_from_a_spec_and_names_what_is_wrong() {
    let plan: CompensationPlan = serde_json::from_str(
        r#"{"mode": "one-step", "operating_point": {"policy": {"kind": "retrain"}}}"#,
    )
    .unwrap();
    assert_eq!(plan.mode, Mode::OneStep);
    assert_eq!(plan.operating_point.policy, RangePolicy::Retrain);
    assert!(serde_json::from_str::<CompensationPlan>(r#"{"mood": 1}"#).is_err());
    let mut plan = CompensationPlan::default();
    plan.convergence.tolerance = -1.0;
    let message = plan.check().unwrap_err().to_string();
    assert_eq!(message, "convergence.tolerance must be positive and finite, got -1");
    let mut plan = CompensationPlan::default();
    plan.hard_fault.least_jump = -0.5;
    let message = plan.check().unwrap_err().to_string();
    assert_eq!(message, "hard_fault.least_jump must be non-negative and finite, got -0.5");
    let mut plan = CompensationPlan::default();
    plan.hard_fault.memory = 0.5;
    let message = plan.check().unwrap_err().to_string();
    assert_eq!(message, "hard_fault.memory must be finite and at least 1, got 0.5");
    let sizes = ResidualCompensator::new(
        FixedParameters::<f64>::new(2, 1, &THETA),
        Arx::<f64, 2>::new(),
        &CompensationPlan::default(),
    );
    assert_eq!(sizes.unwrap_err().to_string(), "identifier has 2 inputs, the bias model has 1");
}
