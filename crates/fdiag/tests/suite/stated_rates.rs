//! Of healthy runs that begin with a fitted bias as many alarm as were stated, whatever the plant, the bias model, the detector and the settling time.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a failure here is a failed test, and what was measured is said"
)]

use std::cell::RefCell;

use crate::support::{run, ts};
use faer::Mat;
use fdiag::{
    core::stage::Stage,
    model::{Discrete, Record, StateSpace},
    spec::{DetectorSpecError, PipelineSpec},
    training::{Healthy, Trace, TrainingError, train},
};
use proptest::{prelude::*, test_runner::TestRunner};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Stated probability of an alarm in a run of so many samples.
const STATED: f64 = 0.1;
const SAMPLES: usize = 400;
/// Healthy logs that are learned from, and fresh runs.
const LOGS: u32 = 20;
const FRESH: u32 = 40;

/// What is drawn.
#[derive(Clone, Debug)]
struct Case {
    seed: u64,
    /// Poles of model and plant, which differ.
    poles: Vec<(f64, f64)>,
    /// Gain of the model's inputs that the plant does not have.
    lost: f64,
    noise: f64,
    order: usize,
    offset: bool,
    learning: &'static str,
    detector: &'static str,
    settle: usize,
}

fn case() -> impl Strategy<Value = Case> {
    let pole = (0.2..0.95_f64, -0.1..0.1_f64).prop_map(|(p, d)| (p, (p * (1.0 + d)).min(0.96)));
    let poles = prop::collection::vec(pole, 1..=3);
    let bias = (1..=3_usize, any::<bool>(), prop::sample::select(vec!["batch", "output-error"]));
    let detector = prop::sample::select(vec![
        "kind = \"n-sigma\"",
        "kind = \"chi-square\", window = 1",
        "kind = \"chi-square\", window = 20",
        "kind = \"cusum\", reference = 1.0",
        "kind = \"sprt\"",
        "kind = \"two-sample\", test = \"mean\", window = 20",
    ]);
    // None, less than a plant may need, and as much.
    let settle = prop::sample::select(vec![0, 10, 80]);
    let plant = (any::<u64>(), poles, -0.2..0.2_f64, 0.01..0.1_f64);
    (plant, bias, detector, settle).prop_map(|(plant, bias, detector, settle)| {
        let ((seed, poles, lost, noise), (order, offset, learning)) = (plant, bias);
        Case { seed, poles, lost, noise, order, offset, learning, detector, settle }
    })
}

/// Real poles side by side, each with an input gain that leaves the gain of the whole at one.
fn system(poles: impl Iterator<Item = f64> + Clone, gain: f64) -> StateSpace<Discrete> {
    let n = poles.clone().count();
    let poles: Vec<f64> = poles.collect();
    let a = Mat::from_fn(n, n, |i, j| if i == j { poles[i] } else { 0.0 });
    let b = Mat::from_fn(n, 1, |i, _| gain * (1.0 - poles[i]) / n as f64);
    let c = Mat::from_fn(1, n, |_, _| 1.0);
    StateSpace::new(a, b, c, Mat::zeros(1, 1), Discrete { ts: ts() }).unwrap()
}

/// A healthy run: random levels for random times.
fn healthy(plant: &StateSpace<Discrete>, noise: f64, seed: u64) -> Record {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let (mut level, mut left) = (0.0, 0);
    let u: Vec<f64> = (0..SAMPLES)
        .map(|_| {
            if left == 0 {
                (level, left) = (random.random_range(-1.0..1.0), random.random_range(5..40));
            }
            left -= 1;
            level
        })
        .collect();
    run(plant, &u, noise, seed)
}

/// How many of the fresh runs alarm; none where the memory of the statistic is too long for the logs, which is said.
fn alarms(case: &Case) -> Option<u32> {
    let Case { order, offset, learning, detector, .. } = case;
    let settle_s = case.settle as f64 * ts().seconds();
    let text = format!(
        "settle_s = {settle_s:?}\n\
         bias.orders = {{ kind = \"fixed\", na = {order}, nb = {}, offset = {offset} }}\n\
         bias.learning = {{ kind = \"{learning}\" }}\n\
         detector = {{ {detector}, false_alarms = {{ kind = \"per-run\", probability = {STATED}, samples = {SAMPLES} }} }}\n\
         calibration = {{ beyond = \"extrapolate\", records = 1 }}",
        order + 1,
    );
    let spec: PipelineSpec = text.parse().unwrap();
    let model = system(case.poles.iter().map(|(model, _)| *model), 1.0);
    let plant = system(case.poles.iter().map(|(_, plant)| *plant), 1.0 - case.lost);
    let run = |i: u32| healthy(&plant, case.noise, case.seed.wrapping_add(u64::from(i)));
    let logs: Vec<Record> = (0..LOGS).map(run).collect();
    let split: Vec<Healthy<'_>> = logs.iter().map(|log| Healthy::split(log, 0.7)).collect();
    let trained = train(&spec, &model, &split).unwrap();
    let mut pipeline = match trained.compensated() {
        Err(TrainingError::Detector(DetectorSpecError::Calibration(_))) => return None,
        pipeline => pipeline.unwrap(),
    };
    let alarm = |i: &u32| {
        pipeline.reset();
        Trace::of(&mut pipeline, &run(LOGS + i)).unwrap().first_alarm(0).is_some()
    };
    Some(u32::try_from((0..FRESH).filter(alarm).count()).unwrap())
}

#[test]
fn the_rate_of_healthy_runs_is_the_stated_one() {
    let config =
        ProptestConfig { cases: 30, failure_persistence: None, ..ProptestConfig::default() };
    let found: RefCell<Vec<f64>> = RefCell::default();
    let mut runner = TestRunner::new(config);
    let outcome = runner.run(&case(), |case| {
        let Some(alarms) = alarms(&case) else { return Ok(()) };
        found.borrow_mut().push(f64::from(alarms) / f64::from(FRESH));
        // The logs calibrate on some six runs, so that the rate of one set of logs may be three times the stated one. At 30 %
        // more than 24 of 40 alarm once in 10⁵ cases; a start that is not calibrated alarms in all of them.
        prop_assert!(alarms <= 24, "{} of {} runs: {:?}", alarms, FRESH, case);
        Ok(())
    });
    assert!(outcome.is_ok(), "{outcome:?}");
    let of = found.borrow();
    assert!(of.len() > 15, "{} of 30 cases were calibrated", of.len());
    let n = of.len() as f64;
    let mean = of.iter().sum::<f64>() / n;
    let variance = of.iter().map(|rate| (rate - mean).powi(2)).sum::<f64>() / (n - 1.0);
    // Four standard errors over the cases, of which each is one draw of logs.
    let error = 4.0 * (variance.max(STATED * (1.0 - STATED) / f64::from(FRESH)) / n).sqrt();
    println!("{mean:.3} of the runs of {n} cases alarm, within {error:.3}");
    assert!((mean - STATED).abs() < error, "{mean} {error} {of:?}");
}
