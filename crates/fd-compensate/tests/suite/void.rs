//! A threshold that follows the input, where the input does what no healthy log has.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use fd_compensate::{
    DrivenRows, SampleRows,
    calibrate::{Beyond, CalibrationPlan, FalseAlarms, calibrate_held_out},
    detect::{
        AdaptiveThreshold, DetectorError, Magnitude,
        adaptive::{Bands, InputBound, LearnedBound},
    },
};
use fd_core::{Snapshot, stage::Detector};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Runs and their samples that thresholds are set on.
const RUNS: usize = 20;
const LENGTH: usize = 600;
/// Stated probability of an alarm in a run.
const STATED: f64 = 0.05;
/// Plants that a step is tried on.
const PLANTS: u32 = 60;

/// A residual that a wrong model leaves: what the input leaves behind a lag, and noise.
struct Plant {
    random: Xoshiro256PlusPlus,
    level: f64,
    lagged: f64,
}

impl Plant {
    fn new(seed: u64) -> Self {
        Self { random: Xoshiro256PlusPlus::seed_from_u64(seed), level: 0.0, lagged: 0.0 }
    }

    fn sample(&mut self) -> (f64, f64) {
        let noise: f64 = StandardNormal.sample(&mut self.random);
        self.lagged += 0.1 * (self.level - self.lagged);
        // High-passed: a lasting level leaves little, a step leaves much for a while.
        (self.level, 0.02 * self.level + 0.3 * (self.level - self.lagged) + 0.003 * noise)
    }

    /// A healthy run with one step of at most 0.1.
    fn run(&mut self) -> Vec<(f64, f64)> {
        (self.level, self.lagged) = (0.0, 0.0);
        let (at, step) = (self.random.random_range(100..500), self.random.random_range(-0.1..0.1));
        (0..LENGTH)
            .map(|k| {
                self.level = if k < at { 0.0 } else { step };
                self.sample()
            })
            .collect()
    }
}

#[derive(Debug)]
#[expect(dead_code, reason = "shown when a test fails")]
struct Failed(String);

impl From<fd_compensate::calibrate::CalibrationError> for Failed {
    fn from(error: fd_compensate::calibrate::CalibrationError) -> Self {
        Self(error.to_string())
    }
}

/// One that follows the input and one that does not, both set on the same runs.
fn thresholds(plant: &mut Plant) -> (AdaptiveThreshold<f64>, Magnitude<f64>) {
    let (u, r): (Vec<f64>, Vec<f64>) = (0..RUNS).flat_map(|_| plant.run()).unzip();
    let starts: Vec<usize> = (1..RUNS).map(|run| run * LENGTH).collect();
    let residuals = SampleRows::new(1, &r).unwrap();
    let healthy = DrivenRows::new(SampleRows::new(1, &u).unwrap(), residuals).unwrap();
    let healthy = healthy.in_runs(&starts).unwrap();
    let learn = |rows: DrivenRows<'_>| -> Result<_, Failed> {
        let bands = Bands::spaced(100.0, 3, 20.0);
        let made = bands.and_then(|bands| {
            let bound = InputBound::from_fault_free(rows, bands, &LearnedBound::default())?;
            AdaptiveThreshold::of_magnitude(&bound.known_on(rows, 0.1)?, 1.0)
        });
        made.map_err(|error: DetectorError| Failed(error.to_string()))
    };
    let wanted = FalseAlarms::PerRun { probability: STATED, samples: LENGTH };
    let plan = CalibrationPlan { beyond: Beyond::Extrapolate, ..CalibrationPlan::default() };
    let (detector, found) = calibrate_held_out(healthy, wanted, &plan, learn).unwrap();
    let constant = Magnitude::above_fault_free_maximum(residuals, 0.05).unwrap();
    (detector.with_threshold(found.threshold).unwrap(), constant)
}

/// Every plant steps four times as far as in any log. The detector says that its threshold is void, for as long as
/// the step matters and no longer, and its bound goes on in proportion; a constant one alarms and says nothing.
#[test]
fn after_a_step_beyond_the_logs_the_rate_is_kept_or_said_to_be_void() {
    let (mut stated, mut any, mut constant_alarms) = (0, 0, 0);
    for seed in 0..PLANTS {
        let mut plant = Plant::new(9_000 + u64::from(seed));
        let (mut detector, mut constant) = thresholds(&mut plant);
        (plant.level, plant.lagged) = (0.0, 0.0);
        let (mut alarms, mut alarms_stated, mut alarms_constant) = (false, false, false);
        let mut void = Vec::new();
        for k in 0..2 * LENGTH {
            // There and back again: a pulse long enough to settle.
            plant.level = if (200..260).contains(&k) { 0.4 } else { 0.0 };
            let (u, r) = plant.sample();
            let alarm = detector.update(&[u], &[r]).alarm();
            alarms |= alarm;
            alarms_stated |= alarm && !detector.is_void();
            alarms_constant |= constant.update(&[u], &[r]).alarm();
            void.push(detector.is_void());
        }
        assert!(!void[..200].contains(&true), "seed {seed}: void in quiet");
        // A fast band of 0.4 over a memory of 20 passes anything that 0.1 leaves within two samples.
        assert!(void[202], "seed {seed}: not void after a step beyond the logs");
        assert!(!void[260 + 300..].contains(&true), "seed {seed}: void for ever");
        stated += u32::from(alarms_stated);
        any += u32::from(alarms);
        constant_alarms += u32::from(alarms_constant);
    }
    println!("alarms: stated {stated}, any {any}, constant {constant_alarms} of {PLANTS}");
    // Two lengths at 5 % each: 6 of 60 expected, standard deviation 2.3.
    assert!(stated <= 15, "{stated}");
    assert!(any <= 15, "the bound goes on in proportion, as the bias does: {any}");
    assert_eq!(constant_alarms, PLANTS, "or else the step shows nothing");
}

/// Without any motion of the input a fault is found as early as with the constant threshold: there the bound is the
/// part of the noise alone, and the constant one has the largest bias in it.
#[test]
fn in_quiet_a_fault_is_found_no_later_than_with_a_constant_threshold() {
    let mut earlier = 0;
    for seed in 0..40 {
        let mut plant = Plant::new(19_000 + seed);
        let (mut detector, mut constant) = thresholds(&mut plant);
        (plant.level, plant.lagged) = (0.0, 0.0);
        let (mut found, mut found_constant) = (None, None);
        for k in 0..LENGTH {
            let (u, r) = plant.sample();
            let fault = 2e-4 * f64::from(u32::try_from(k.saturating_sub(100)).unwrap());
            if detector.update(&[u], &[r + fault]).alarm() {
                found = found.or(Some(k));
            }
            if constant.update(&[u], &[r + fault]).alarm() {
                found_constant = found_constant.or(Some(k));
            }
        }
        assert!(found.unwrap() <= found_constant.unwrap(), "{found:?} {found_constant:?}");
        earlier += u32::from(found < found_constant);
    }
    assert!(earlier > 30, "{earlier}");
}

#[test]
fn whether_a_threshold_is_void_is_saved_and_forgotten_at_a_reset() {
    let (u, r) = ([1.0, 1.0], [0.1, 0.2]);
    let rows = DrivenRows::new(SampleRows::new(1, &u).unwrap(), SampleRows::new(1, &r).unwrap());
    let bound = InputBound::new(Bands::new(&[], 1.0).unwrap(), 1, &[1.0], &[1.0]).unwrap();
    assert!(bound.clone().known_on(rows.unwrap(), -0.1).is_err());
    assert!(bound.clone().known_on(SampleRows::new(1, &r).unwrap().into(), 0.1).is_err());
    let known = bound.clone().known_on(rows.unwrap(), 0.2).unwrap();
    let mut detector = AdaptiveThreshold::<f64>::of_magnitude(&known, 1.0).unwrap();
    // Left above 1.2, regained below 1.1.
    for (u, void) in [(1.15, false), (1.25, true), (1.15, true), (1.05, false), (1.15, false)] {
        detector.update(&[u], &[0.0]);
        assert_eq!(detector.is_void(), void, "{u}");
    }
    detector.update(&[1.25], &[0.0]);
    let mut other = AdaptiveThreshold::<f64>::of_magnitude(&known, 1.0).unwrap();
    Snapshot::of(&mut detector).restore(&mut other).unwrap();
    other.update(&[1.15], &[0.0]);
    assert!(other.is_void());
    fd_core::stage::Stage::<f64>::reset(&mut other);
    other.update(&[1.15], &[0.0]);
    assert!(!other.is_void());
    // Nobody said where it holds: everywhere.
    let mut anywhere = AdaptiveThreshold::<f64>::of_magnitude(&bound, 1.0).unwrap();
    anywhere.update(&[1e9], &[0.0]);
    assert!(!anywhere.is_void());
}
