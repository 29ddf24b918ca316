//! A plant that changes while the switch is open, told apart from faults.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use crate::support::{Arx2, Subject, bits, kinds, paper_input, response, run, subject};
use fd_compensate::residual_compensation::{
    ChangePolicy, CompensationPlan, FixedParameters, PlantChange, PreFitted, ResidualCompensator,
};
use fd_core::{EventKind, Snapshot, StateVisitor, stage::Stage};
use proptest::prelude::*;

use EventKind::{CharacteristicsChanged, Frozen, HardFaultWhileTraining, TrainingStarted};

const THETA: [f64; 5] = [-1.3, 0.4, 0.05, -0.02, 0.01];
/// The plant changes here, long after the switch opened.
const CHANGE: usize = 2000;
const SAMPLES: usize = 5000;

fn plan(policy: ChangePolicy) -> CompensationPlan {
    let plant_change = PlantChange { policy, window: 200, ..PlantChange::default() };
    let mut plan = CompensationPlan { plant_change, ..CompensationPlan::default() };
    // Noise of this size keeps parameters from standing still to a thousandth.
    plan.convergence.tolerance = 1e-2;
    plan
}

/// Uniform numbers between −1 and 1 from a linear congruential generator (Knuth 1997).
fn noise(seed: u64, n: usize) -> Vec<f64> {
    let mut state = seed;
    (0..n)
        .map(|_| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        })
        .collect()
}

/// The healthy residual with noise, 1 % of the bias.
fn healthy(seed: u64, u: &[f64]) -> Vec<f64> {
    response::<2>(&THETA, u).iter().zip(noise(seed, u.len())).map(|(r, e)| r + 0.01 * e).collect()
}

/// The bias of a plant whose gain changes by `share` over `ramp` samples.
fn changed(seed: u64, u: &[f64], share: f64, ramp: f64) -> Vec<f64> {
    let mut r = healthy(seed, u);
    for (k, r) in r.iter_mut().enumerate().skip(CHANGE) {
        *r *= 1.0 + share * ((k - CHANGE) as f64 / ramp).min(1.0);
    }
    r
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m: f64, v| m.max(v.abs()))
}

#[test]
fn a_changed_plant_is_learned_again() {
    let u = paper_input(SAMPLES);
    let r = changed(1, &u, 0.5, 1.0);
    let (star, log) = run(&mut subject::<f64>(&plan(ChangePolicy::Retrain)), &u, &r);
    assert_eq!(
        kinds(&log),
        [TrainingStarted, Frozen, CharacteristicsChanged, TrainingStarted, Frozen],
        "{log:?}"
    );
    // Two windows of 200 see it, a third when the change falls into the middle of one.
    assert!((CHANGE..CHANGE + 600).contains(&log[2].0), "{log:?}");
    let last = &star[SAMPLES - 500..];
    // Three times the noise.
    assert!(largest(last) < 0.03, "{}", largest(last));
    // Warned of only, the bias of the changed plant stays.
    let (star, log) = run(&mut subject::<f64>(&plan(ChangePolicy::Warn)), &u, &r);
    assert_eq!(kinds(&log), [TrainingStarted, Frozen, CharacteristicsChanged]);
    assert!(largest(&star[SAMPLES - 500..]) > 0.06);
    // And nobody looks unless asked to.
    let (_, log) = run(&mut subject::<f64>(&plan(ChangePolicy::Ignore)), &u, &r);
    assert_eq!(kinds(&log), [TrainingStarted, Frozen]);
}

/// Where a nonlinear model has no answer the residual is NaN for a sample: in the window that says what is healthy, or
/// in one that is compared with it.
#[test]
fn a_sample_without_a_residual_hides_no_change() {
    let u = paper_input(SAMPLES);
    let r = changed(1, &u, 0.5, 1.0);
    let plan = plan(ChangePolicy::Warn);
    let frozen = run(&mut subject::<f64>(&plan), &u, &r).1[1].0;
    for lost in [frozen + 100, CHANGE + 100] {
        let mut r = r.clone();
        r[lost] = f64::NAN;
        let log = run(&mut subject::<f64>(&plan), &u, &r).1;
        assert_eq!(kinds(&log), [TrainingStarted, Frozen, CharacteristicsChanged], "{lost}");
        assert!((CHANGE..CHANGE + 601).contains(&log[2].0), "{log:?}");
    }
}

/// Section 3: while parameters adapt again, a hard fault still shows.
#[test]
fn a_hard_fault_while_learning_again_is_reported() {
    let u = paper_input(SAMPLES);
    let mut r = changed(2, &u, 0.5, 1.0);
    let mut plan = plan(ChangePolicy::Retrain);
    plan.convergence.least_samples = 400;
    let log = run(&mut subject::<f64>(&plan), &u, &r).1;
    let again = log.iter().filter(|(_, kind)| *kind == TrainingStarted).nth(1).unwrap().0;
    let peak = largest(&r);
    r[again + 200..again + 300].iter_mut().for_each(|r| *r += 2.0 * peak);
    let log = run(&mut subject::<f64>(&plan), &u, &r).1;
    assert!(log.contains(&(again + 200, HardFaultWhileTraining)), "{log:?}");
}

#[derive(Clone, Copy, Debug)]
enum Shape {
    Step,
    Ramp,
    Sine,
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, failure_persistence: None, ..Default::default() })]

    /// Whatever a sensor fault is like, it is left to the detector: it does not follow the inputs.
    #[test]
    fn a_sensor_fault_is_no_change_of_the_plant(
        seed: u64,
        shape in prop::sample::select(vec![Shape::Step, Shape::Ramp, Shape::Sine]),
        size in prop::sample::select(vec![-1.0, -0.1, 0.03, 0.3, 1.0]),
        length in 1.0..1500.0_f64,
        start in 0_usize..400,
    ) {
        let u = paper_input(SAMPLES);
        let mut r = healthy(seed, &u);
        for (k, r) in r.iter_mut().skip(CHANGE + start).enumerate() {
            let k = k as f64;
            *r += size * match shape {
                Shape::Step => 1.0,
                Shape::Ramp => (k / length).min(1.0),
                // No frequency of the input, 0.05, 0.31 and 1.1.
                Shape::Sine => (0.15 * k).sin(),
            };
        }
        let log = run(&mut subject::<f64>(&plan(ChangePolicy::Retrain)), &u, &r).1;
        prop_assert_eq!(kinds(&log), [TrainingStarted, Frozen], "{:?}", log);
    }

    /// A gain that moves by a third or more is a change, however slowly it comes.
    #[test]
    fn a_drift_of_the_plant_is_a_change(
        seed: u64, share in 0.33..1.0_f64, sign in prop::sample::select(vec![-1.0, 1.0]), ramp in 1.0..1500.0_f64,
    ) {
        let u = paper_input(SAMPLES);
        let r = changed(seed, &u, sign * share, ramp);
        let log = run(&mut subject::<f64>(&plan(ChangePolicy::Retrain)), &u, &r).1;
        let first = log.iter().find(|(_, kind)| *kind == CharacteristicsChanged);
        prop_assert!(first.is_some_and(|&(k, _)| k >= CHANGE), "{:?}", log);
        prop_assert!(log.iter().filter(|(_, kind)| *kind == Frozen).count() >= 2, "{:?}", log);
    }

    #[test]
    fn reset_and_restore_give_the_same_future(cut in 0_usize..SAMPLES) {
        let u = paper_input(SAMPLES);
        let r = changed(3, &u, 0.5, 300.0);
        let plan = plan(ChangePolicy::Retrain);
        let fresh = || -> Subject { subject::<f64>(&plan).settling(30) };
        let mut one = fresh();
        let (first, first_log) = run(&mut one, &u[..cut], &r[..cut]);
        let snapshot = Snapshot::of(&mut one);
        let (second, second_log) = run(&mut one, &u[cut..], &r[cut..]);
        let mut two = fresh();
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

/// A healthy plant whose input becomes three times as lively: what the bias model leaves grows with it.
#[test]
fn a_lively_input_is_no_change() {
    let mut u = paper_input(SAMPLES);
    u[CHANGE..].iter_mut().for_each(|u| *u = 1.0 + 3.0 * (*u - 1.0));
    // A bias model that is a tenth wrong, so that what it leaves follows the inputs from the start.
    let r: Vec<f64> = response::<2>(&THETA, &u).iter().map(|r| 1.1 * r).collect();
    let fit = PreFitted {
        theta: THETA.to_vec(),
        input_low: vec![-10.0],
        input_high: vec![10.0],
        residual_peak: 1.0,
        filling: 0,
    };
    let plan = plan(ChangePolicy::Retrain);
    let identifier = FixedParameters::new(1, 1, &THETA);
    let mut fitted =
        ResidualCompensator::pre_fitted(identifier, Arx2::<f64>::new(), fit, &plan).unwrap();
    assert_eq!(kinds(&run(&mut fitted, &u, &r).1), []);
}

/// Nothing is learned, and nothing is said, before the generator has settled.
#[test]
fn a_training_waits_for_the_generator() {
    let u = paper_input(1000);
    let mut r = response::<2>(&THETA, &u);
    // A generator that starts far off: it would be learned as bias, or taken for a hard fault.
    for (k, r) in r.iter_mut().take(60).enumerate() {
        *r += 50.0 * 0.8_f64.powi(i32::try_from(k).unwrap());
    }
    let mut compensator = subject::<f64>(&CompensationPlan::default()).settling(60);
    let (star, log) = run(&mut compensator, &u, &r);
    assert_eq!(log[0], (60, TrainingStarted));
    assert_eq!(kinds(&log), [TrainingStarted, Frozen]);
    assert_eq!(bits(&star[..60]), bits(&r[..60]));
    assert!(largest(&star[log[1].0 + 1..]) < 1e-3 * largest(&r[60..]));
}

#[test]
fn settings_out_of_range_are_named() {
    let refused = |change: PlantChange| {
        let plan = CompensationPlan { plant_change: change, ..CompensationPlan::default() };
        plan.check().unwrap_err().to_string()
    };
    let default = PlantChange::default;
    assert_eq!(
        refused(PlantChange { window: 19, ..default() }),
        "plant_change.window must be at least 20, got 19"
    );
    assert_eq!(
        refused(PlantChange { share: 1.0, ..default() }),
        "plant_change.share must be between 0 and 1, got 1"
    );
    assert_eq!(
        refused(PlantChange { growth: f64::NAN, ..default() }),
        "plant_change.growth must be finite and at least 1, got NaN"
    );
}

/// Asks for the numbers that a snapshot holds.
#[derive(Default)]
struct Numbers(usize);

impl StateVisitor<f64> for Numbers {
    fn reals(&mut self, _: &'static str, values: &mut [f64]) {
        self.0 += values.len();
    }

    fn counts(&mut self, _: &'static str, values: &mut [u64]) {
        self.0 += values.len();
    }
}

/// Snapshots of compensators that do not watch the plant are what they were before there was a watch.
#[test]
fn who_does_not_watch_remembers_nothing_for_it() {
    let numbers = |policy| {
        let (mut compensator, mut numbers) = (subject::<f64>(&plan(policy)), Numbers::default());
        compensator.visit_state(&mut numbers);
        numbers.0
    };
    // 2 low-passes, 5 × 5 and 5 products, 1 square, 5 parameters, 2 references, 3 counts.
    assert_eq!(numbers(ChangePolicy::Warn) - numbers(ChangePolicy::Ignore), 43);
}
