//! The two stages: training, freezing, compensating, and what interrupts them.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use crate::support::{Subject, bits, kinds, paper_input, response, run, subject};
use fd_compensate::residual_compensation::{CompensationPlan, RangePolicy, Timeout};
use fd_core::{
    EventKind, Scalar, Snapshot,
    stage::{Compensator, Stage},
};
use proptest::prelude::*;

use EventKind::{
    Frozen, HardFaultWhileTraining, OperatingPointLeft, OperatingPointRegained, TrainingStarted,
};

/// A bias of moderate speed, so that trials need not be long: poles 0.8 and 0.5.
const THETA: [f64; 5] = [-1.3, 0.4, 0.05, -0.02, 0.01];

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
fn a_hard_fault_in_training_is_reported_and_not_learned() {
    let u = paper_input(3000);
    let healthy = response::<2>(&THETA, &u);
    let mut r = healthy.clone();
    // A sensor jumps by twice the largest bias for 300 samples, after the input has shown its range.
    let peak = healthy.iter().fold(0.0_f64, |p, v| p.max(v.abs()));
    r[400..700].iter_mut().for_each(|v| *v += 2.0 * peak);
    let mut plan = CompensationPlan::default();
    plan.convergence.least_samples = 600;
    let (star, log) = run(&mut subject::<f64>(&plan), &u, &r);
    assert_eq!(log[0], (0, TrainingStarted));
    assert_eq!(log[1], (400, HardFaultWhileTraining));
    // While paused r* shows the fault: the simulation knows nothing of it.
    assert!(star[400..700].iter().all(|v| (v - 2.0 * peak).abs() < 0.5 * peak));
    assert_eq!(log[2], (720, TrainingStarted));
    assert_eq!(log[3].1, EventKind::Frozen);
    let left = star[log[3].0 + 1..].iter().fold(0.0_f64, |p, v| p.max(v.abs()));
    assert!(left < 1e-3 * peak, "{left}");
}

#[test]
fn a_hard_fault_that_stays_shows_once_the_time_is_up() {
    let u = paper_input(1500);
    let mut r = response::<2>(&THETA, &u);
    let peak = r.iter().fold(0.0_f64, |p, v| p.max(v.abs()));
    r[400..].iter_mut().for_each(|v| *v += 2.0 * peak);
    let mut plan = CompensationPlan::default();
    plan.convergence.least_samples = 600;
    plan.convergence.longest = Some(1000);
    plan.convergence.at_longest = Timeout::FreezeAnyway;
    let (star, log) = run(&mut subject::<f64>(&plan), &u, &r);
    let late = EventKind::TrainingInconclusive;
    assert_eq!(
        log,
        [(0, TrainingStarted), (400, HardFaultWhileTraining), (999, late), (999, Frozen)]
    );
    assert!(star[1000..].iter().all(|v| (v - 2.0 * peak).abs() < 1e-3 * peak));
}

/// The engine idles, then the test begins: the innovation jumps because the input does.
#[test]
fn an_input_step_in_training_is_no_hard_fault() {
    let mut u = paper_input(3000);
    u[..150].fill(0.0);
    let r = response::<2>(&THETA, &u);
    let log = run(&mut subject::<f64>(&CompensationPlan::default()), &u, &r).1;
    assert_eq!(kinds(&log), [TrainingStarted, Frozen]);
}

#[test]
fn a_candidate_that_does_not_help_is_rejected_until_time_is_up() {
    let mut plan = CompensationPlan::default();
    // No simulation is that good: the prior of the estimator leaves its mark.
    plan.trial.worst_ratio = 1e-12;
    plan.convergence.longest = Some(1000);
    plan.convergence.at_longest = Timeout::FreezeAnyway;
    let u = paper_input(1200);
    let r = response::<2>(&THETA, &u);
    let (star, log) = run(&mut subject::<f64>(&plan), &u, &r);
    let kinds = kinds(&log);
    let rejected = kinds.iter().filter(|k| **k == EventKind::BiasModelRejected).count();
    // From sample 200 on each trial of 50 follows a streak of 50.
    assert_eq!(rejected, 8, "{log:?}");
    assert_eq!(log[log.len() - 2..], [(999, EventKind::TrainingInconclusive), (999, Frozen)]);
    let peak = r.iter().fold(0.0_f64, |p, v| p.max(v.abs()));
    assert!(star[1000..].iter().all(|v| v.abs() < 1e-3 * peak));
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
fn training_again_can_be_a_question() {
    let u = moved_input();
    let r = response::<2>(&THETA, &u);
    let plan = CompensationPlan { ask: true, ..plan_with(RangePolicy::Retrain) };
    let unanswered = run(&mut subject::<f64>(&plan), &u, &r).1;
    let expected = [
        OperatingPointLeft,
        EventKind::RetrainingWanted,
        OperatingPointRegained,
        EventKind::RetrainingWithdrawn,
    ];
    assert_eq!(kinds(&unanswered)[2..], expected, "asked once, and nothing is trained");

    let mut compensator = subject::<f64>(&plan);
    run(&mut compensator, &u[..2000], &r[..2000]);
    assert!(Compensator::<f64>::retrain(&mut compensator));
    let answered = run(&mut compensator, &u[2000..2900], &r[2000..2900]).1;
    assert_eq!(kinds(&answered), [TrainingStarted, Frozen]);
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
    r[400..480].iter_mut().for_each(|v| *v += 5.0);
    let mut plan = plan_with(RangePolicy::RetrainAfter { samples: 50, band: 0.5 });
    plan.convergence.least_samples = 450;
    (plan, u, r)
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
