//! The two stages: training, freezing, compensating, and what interrupts them.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

mod support;

use fd_compensate::residual_compensation::{
    CompensationPlan, FixedParameters, Mode, PreFitted, RangePolicy, ResidualCompensator, Timeout,
};
use fd_core::{
    EventKind, Scalar, Snapshot,
    stage::{Phase, Stage},
};
use proptest::prelude::*;
use support::{Arx, PAPER_THETA, Subject, paper_input, push, response, run, subject};

use EventKind::{
    Frozen, HardFaultWhileTraining, OperatingPointLeft, OperatingPointRegained, TrainingStarted,
};

/// A bias of moderate speed, so that trials need not be long: poles 0.8 and 0.5.
const THETA: [f64; 5] = [-1.3, 0.4, 0.05, -0.02, 0.01];

fn kinds(log: &[(usize, EventKind)]) -> Vec<EventKind> {
    log.iter().map(|&(_, kind)| kind).collect()
}

fn frozen_at(log: &[(usize, EventKind)]) -> usize {
    log.iter().find(|(_, kind)| *kind == EventKind::Frozen).map(|(k, _)| *k).unwrap()
}

#[test]
fn learns_freezes_and_removes_the_bias() {
    let u = paper_input(2000);
    let r = response::<2>(&THETA, &u);
    let mut compensator = subject::<f64>(&CompensationPlan::default());
    let (star, log) = run(&mut compensator, &u, &r);
    assert_eq!(kinds(&log), [EventKind::TrainingStarted, EventKind::Frozen]);
    let frozen = frozen_at(&log);
    // 200 samples at least, 50 of trial.
    assert!((249..500).contains(&frozen), "frozen at {frozen}");
    let peak = r.iter().fold(0.0_f64, |p, v| p.max(v.abs()));
    let left = star[frozen + 1..].iter().fold(0.0_f64, |p, v| p.max(v.abs()));
    // The prior (variance 1e6) weighs little, but not nothing, along directions that u hardly excites.
    assert!(left < 1e-4 * peak, "left {left} of {peak}");
    let theta = compensator.theta().unwrap();
    assert!(theta.iter().zip(THETA).all(|(a, b)| (a - b).abs() < 5e-3), "{theta:?}");
}

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
fn a_constant_input_never_ends_a_training() {
    let plan = CompensationPlan {
        convergence: fd_compensate::residual_compensation::Convergence {
            longest: Some(1000),
            at_longest: Timeout::TrainAgain,
            ..Default::default()
        },
        ..Default::default()
    };
    let u = vec![1.0; 2500];
    let r = vec![0.3; 2500];
    let (_, log) = run(&mut subject::<f64>(&plan), &u, &r);
    assert_eq!(
        log,
        [
            (0, EventKind::TrainingStarted),
            (999, EventKind::TrainingInconclusive),
            (1000, EventKind::TrainingStarted),
            (1999, EventKind::TrainingInconclusive),
            (2000, EventKind::TrainingStarted),
        ]
    );
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
fn a_hard_fault_in_training_is_reported_and_not_learned() {
    let u = paper_input(3000);
    let healthy = response::<2>(&THETA, &u);
    let mut r = healthy.clone();
    // A sensor jumps by twice the largest bias for 300 samples.
    let peak = healthy.iter().fold(0.0_f64, |p, v| p.max(v.abs()));
    r[180..480].iter_mut().for_each(|v| *v += 2.0 * peak);
    let (star, log) = run(&mut subject::<f64>(&CompensationPlan::default()), &u, &r);
    assert_eq!(log[0], (0, EventKind::TrainingStarted));
    assert_eq!(log[1], (180, EventKind::HardFaultWhileTraining));
    // While paused r* shows the fault: the simulation knows nothing of it.
    assert!(star[180..480].iter().all(|v| (v - 2.0 * peak).abs() < 0.5 * peak));
    assert_eq!(log[2], (500, EventKind::TrainingStarted));
    assert_eq!(log[3].1, EventKind::Frozen);
    let left = star[log[3].0 + 1..].iter().fold(0.0_f64, |p, v| p.max(v.abs()));
    assert!(left < 1e-3 * peak, "{left}");
}

fn moved_input() -> Vec<f64> {
    // 1500 samples around 1, 1500 around 3, back to 1.
    let base = paper_input(4500);
    base.iter()
        .enumerate()
        .map(|(k, v)| if (1500..3000).contains(&k) { v + 2.0 } else { *v })
        .collect()
}

fn plan_with(policy: RangePolicy) -> CompensationPlan {
    let mut plan = CompensationPlan::default();
    plan.operating_point.policy = policy;
    plan
}

#[test]
fn the_operating_point_is_watched() {
    let u = moved_input();
    let r = response::<2>(&THETA, &u);
    let events = |policy| run(&mut subject::<f64>(&plan_with(policy)), &u, &r).1;

    let start = [TrainingStarted, Frozen];
    assert_eq!(kinds(&events(RangePolicy::Ignore)), start);

    let log = events(RangePolicy::Warn);
    assert_eq!(kinds(&log)[2..], [OperatingPointLeft, OperatingPointRegained]);
    // Low-pass of 20 samples: both within a few of its time constants.
    assert!((1500..1560).contains(&log[2].0) && (3000..3060).contains(&log[3].0), "{log:?}");

    let log = events(RangePolicy::Retrain);
    assert_eq!(kinds(&log)[2..5], [OperatingPointLeft, TrainingStarted, Frozen]);
    assert_eq!(log[3].0, log[2].0 + 1);

    let settled = RangePolicy::RetrainAfter { samples: 100, band: 0.5 };
    let log = events(settled);
    assert_eq!(kinds(&log)[2..5], [OperatingPointLeft, TrainingStarted, Frozen]);
    assert!(log[3].0 >= log[2].0 + 100, "{log:?}");
    // A band that the sinusoid never satisfies: no re-training.
    let restless = RangePolicy::RetrainAfter { samples: 100, band: 0.01 };
    assert_eq!(kinds(&events(restless))[2..], [OperatingPointLeft, OperatingPointRegained]);
}

#[test]
fn a_precision_demand_prolongs_a_noisy_training() {
    let u = paper_input(20_000);
    let mut r = response::<2>(&THETA, &u);
    let mut noise = 0.3_f64;
    for v in &mut r {
        // Logistic map: a reproducible, white-looking disturbance.
        noise = 3.99 * noise * (1.0 - noise);
        *v += 0.01 * (noise - 0.5);
    }
    let frozen = |bound| {
        let mut plan = CompensationPlan::default();
        plan.convergence.tolerance = 1e-2;
        plan.convergence.relative_standard_error = bound;
        frozen_at(&run(&mut subject::<f64>(&plan), &u, &r).1)
    };
    let (free, bound) = (frozen(None), frozen(Some(0.02)));
    assert!(free < bound, "{free} {bound}");
}

#[test]
fn runs_in_single_precision() {
    let input = paper_input(3000);
    let single = |values: &[f64]| values.iter().map(|&v| f32::from_design(v)).collect::<Vec<_>>();
    let (u, r) = (single(&input), single(&response::<2>(&THETA, &input)));
    let mut plan = CompensationPlan::default();
    // Plain recursive least squares in f32 wanders at 1e-3.
    plan.convergence.tolerance = 5e-3;
    let (star, log) = run(&mut subject::<f32>(&plan), &u, &r);
    let frozen = frozen_at(&log);
    let peak = r.iter().fold(0.0_f32, |p, v| p.max(v.abs()));
    assert!(star[frozen + 1..].iter().all(|v| v.abs() < 0.05 * peak));
}

/// Goes through every activity: learning, trial, compensating, paused, re-training.
fn eventful() -> (CompensationPlan, Vec<f64>, Vec<f64>) {
    let u = moved_input();
    let mut r = response::<2>(&THETA, &u);
    r[180..260].iter_mut().for_each(|v| *v += 5.0);
    (plan_with(RangePolicy::RetrainAfter { samples: 50, band: 0.5 }), u, r)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// In simulation mode healthy + fault gives the healthy r* plus the fault's own residual.
    #[test]
    fn a_fault_adds_exactly(
        seed in 0.0..6.0_f64,
        sizes in prop::collection::vec(-1.0..1.0_f64, 200),
    ) {
        let u: Vec<f64> = paper_input(900).iter().zip(0..).map(|(v, k)| v + 0.1 * (seed + f64::from(k)).sin()).collect();
        let healthy = response::<2>(&THETA, &u);
        let plan = CompensationPlan::default();
        let mut trained: Subject = subject(&plan);
        let (_, log) = run(&mut trained, &u[..700], &healthy[..700]);
        prop_assert!(log.iter().any(|e| e.1 == EventKind::Frozen));
        let mut other = trained.clone();
        let (clean, _) = run(&mut trained, &u[700..], &healthy[700..]);
        let faulty: Vec<f64> = healthy[700..].iter().zip(&sizes).map(|(r, f)| r + f).collect();
        let (dirty, _) = run(&mut other, &u[700..], &faulty);
        for ((clean, dirty), f) in clean.iter().zip(&dirty).zip(&sizes) {
            // One rounding of r + f and one of each subtraction: 3 eps of the largest term (< 4).
            prop_assert!((dirty - clean - f).abs() <= 12.0 * f64::EPSILON);
        }
    }

    #[test]
    fn reset_and_restore_give_the_same_future(cut in 0_usize..4500) {
        let (plan, u, r) = eventful();
        let mut one: Subject = subject(&plan);
        let (first, first_log) = run(&mut one, &u[..cut], &r[..cut]);
        let snapshot = Snapshot::of(&mut one);
        let (second, second_log) = run(&mut one, &u[cut..], &r[cut..]);

        let mut two: Subject = subject(&plan);
        snapshot.restore(&mut two).unwrap();
        let (again, again_log) = run(&mut two, &u[cut..], &r[cut..]);
        prop_assert_eq!(bits(&second), bits(&again));
        prop_assert_eq!(&second_log, &again_log);

        one.reset();
        let (restart, restart_log) = run(&mut one, &u[..cut], &r[..cut]);
        prop_assert_eq!(bits(&first), bits(&restart));
        prop_assert_eq!(&first_log, &restart_log);
    }
}

#[test]
fn the_eventful_run_visits_every_activity() {
    let (plan, u, r) = eventful();
    let log = run(&mut subject::<f64>(&plan), &u, &r).1;
    let expected = [
        TrainingStarted,
        HardFaultWhileTraining,
        TrainingStarted,
        Frozen,
        OperatingPointLeft,
        TrainingStarted,
        Frozen,
    ];
    assert_eq!(kinds(&log)[..7], expected, "{log:?}");
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
    let sizes = ResidualCompensator::new(
        FixedParameters::<f64>::new(2, 1, &THETA),
        Arx::<f64, 2>::new(),
        &CompensationPlan::default(),
    );
    assert_eq!(sizes.unwrap_err().to_string(), "identifier has 2 inputs, the bias model has 1");
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| v.to_bits()).collect()
}
