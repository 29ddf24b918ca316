//! Thresholds of detectors that are learned from the runs that they are calibrated on.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use fd_compensate::{
    DrivenRows, RowsError, SampleRows,
    calibrate::{
        Beyond, CalibratedThreshold, CalibrationError, CalibrationPlan, FalseAlarms,
        calibrate_held_out,
    },
    detect::{
        AdaptiveThreshold, DetectorError,
        adaptive::{Bands, Evaluation, InputBound, LearnedBound},
    },
};
use fd_core::stage::{Detector, Stage};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Samples of a run.
const RUN: usize = 200;
/// Records of runs, each with a bound of its own.
const RECORDS: u64 = 40;

/// Input and residual of runs from rest: a level, a step and two tones drawn anew for each, the lag and the
/// wrong gain that the model misses, and coloured noise.
struct Runs {
    u: Vec<f64>,
    r: Vec<f64>,
    starts: Vec<usize>,
}

impl Runs {
    fn draw(count: usize, seed: u64) -> Self {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let (mut u, mut r) = (Vec::new(), Vec::new());
        for _ in 0..count {
            let level = random.random_range(-1.0..1.0);
            let (step, at) = (random.random_range(-1.0..1.0), random.random_range(40..160));
            let tones = [(); 2].map(|()| {
                let slow: f64 = random.random_range(0.0..1.0);
                (0.02 * 50.0_f64.powf(slow), random.random_range(0.1..0.3), 6.3 * slow)
            });
            let (mut slow, mut fast, mut colour) = (0.0, 0.0, 0.0);
            for k in 0..RUN {
                let t = f64::from(u32::try_from(k).unwrap());
                let wave: f64 = tones.iter().map(|(w, a, phase)| a * (w * t + phase).sin()).sum();
                let now = level + wave + if k < at { 0.0 } else { step };
                slow += 0.03 * (now - slow);
                fast += 0.3 * (now - fast);
                let noise: f64 = StandardNormal.sample(&mut random);
                colour = 0.7 * colour + 0.02 * noise;
                u.push(now);
                r.push(0.3 * slow - 0.2 * fast + colour);
            }
        }
        Self { u, r, starts: (1..count).map(|run| run * RUN).collect() }
    }

    fn rows(&self) -> DrivenRows<'_> {
        let inputs = SampleRows::new(1, &self.u).unwrap();
        let rows = DrivenRows::new(inputs, SampleRows::new(1, &self.r).unwrap()).unwrap();
        rows.in_runs(&self.starts).unwrap()
    }

    /// Statistics of each run by a detector that begins anew with it.
    fn judged(&self, detector: &mut AdaptiveThreshold<f64>) -> Vec<Vec<f64>> {
        let judge = |(u, r): (&[f64], &[f64])| {
            detector.reset();
            u.iter().zip(r).map(|(u, r)| detector.update(&[*u], &[*r]).statistic).collect()
        };
        self.u.chunks(RUN).zip(self.r.chunks(RUN)).map(judge).collect()
    }
}

#[derive(Debug, PartialEq)]
enum Failed {
    Detector(DetectorError),
    Calibration(CalibrationError),
}

impl From<CalibrationError> for Failed {
    fn from(error: CalibrationError) -> Self {
        Self::Calibration(error)
    }
}

fn learn(rows: DrivenRows<'_>, evaluation: Evaluation) -> Result<AdaptiveThreshold<f64>, Failed> {
    let bands = Bands::spaced(50.0, 3, 20.0).unwrap();
    let learned = LearnedBound { evaluation, ..LearnedBound::default() };
    InputBound::from_fault_free(rows, bands, &learned)
        .and_then(|bound| AdaptiveThreshold::new(&bound, evaluation, 1.0))
        .map_err(Failed::Detector)
}

fn calibrated(
    runs: &Runs,
    wanted: FalseAlarms,
    evaluation: Evaluation,
    beyond: Beyond,
) -> Result<(AdaptiveThreshold<f64>, CalibratedThreshold), Failed> {
    let plan = CalibrationPlan { beyond, ..CalibrationPlan::default() };
    calibrate_held_out(runs.rows(), wanted, &plan, |rows| learn(rows, evaluation))
}

/// Mean over records and its standard error; records are independent, runs of one are not.
fn mean(of: &[f64]) -> (f64, f64) {
    let n = of.len() as f64;
    let mean = of.iter().sum::<f64>() / n;
    let squares: f64 = of.iter().map(|v| (v - mean).powi(2)).sum();
    (mean, (squares / (n - 1.0) / n).sqrt())
}

#[test]
fn a_learned_bound_keeps_its_rate_on_runs_with_other_inputs() {
    let per_run = |probability| FalseAlarms::PerRun { probability, samples: RUN };
    let per_sample = |rate| FalseAlarms::PerSample { rate };
    for (runs, wanted, stated) in [
        (19, per_run(0.1), 0.1),
        (39, per_run(0.05), 0.05),
        (39, per_sample(0.05), 0.05),
        // Beyond what the runs resolve.
        (12, per_run(0.02), 0.02),
        (12, per_sample(0.005), 0.005),
    ] {
        for evaluation in [Evaluation::Magnitude, Evaluation::RootMeanSquare] {
            let (mut kept, mut seen) = (Vec::new(), Vec::new());
            for record in 0..RECORDS {
                let healthy = Runs::draw(runs, 7000 + record);
                let (mut detector, found) =
                    calibrated(&healthy, wanted, evaluation, Beyond::Extrapolate).unwrap();
                assert_eq!(found.extrapolated, stated < 1.0 / (runs + 1) as f64 * 0.999);
                assert!(found.low <= found.threshold && found.threshold <= found.high);
                let rate = |judged: &[Vec<f64>]| {
                    let above = |v: &&f64| **v > found.threshold;
                    let share = |run: &Vec<f64>| match wanted {
                        FalseAlarms::PerRun { .. } => {
                            f64::from(u8::from(run.iter().any(|v| above(&v))))
                        }
                        FalseAlarms::PerSample { .. } => {
                            run.iter().filter(above).count() as f64 / RUN as f64
                        }
                    };
                    judged.iter().map(share).sum::<f64>() / judged.len() as f64
                };
                kept.push(rate(&Runs::draw(20, 17_000 + record).judged(&mut detector)));
                seen.push(rate(&healthy.judged(&mut detector)));
            }
            let ((kept, error), (seen, _)) = (mean(&kept), mean(&seen));
            println!(
                "{runs} runs, {wanted:?}, {evaluation:?}: {kept:.4} ± {error:.4}, own {seen:.4}"
            );
            // The promise is one on average over records: four standard errors of that average. It must not
            // be kept by hardly ever alarming either.
            assert!(kept < stated + 4.0 * error, "{kept} for {stated}");
            assert!(kept + 4.0 * error > 0.5 * stated, "{kept} for {stated}");
            assert!(seen < kept, "what was learned from fits better: {seen} {kept}");
        }
    }
}

#[test]
fn what_the_runs_cannot_promise_is_refused() {
    let healthy = Runs::draw(12, 1);
    let wanted = FalseAlarms::PerRun { probability: 0.05, samples: RUN };
    let refusal = calibrated(&healthy, wanted, Evaluation::Magnitude, Beyond::Refuse).unwrap_err();
    let Failed::Calibration(refusal) = refusal else { panic!("{refusal:?}") };
    let CalibrationError::TooFewStretches { needed, found, .. } = refusal else {
        panic!("{refusal}")
    };
    assert_eq!((needed, found), (19, 12), "{refusal}");
    let few = Runs::draw(4, 1);
    let error = calibrated(&few, wanted, Evaluation::Magnitude, Beyond::Extrapolate).unwrap_err();
    assert!(matches!(error, Failed::Calibration(CalibrationError::TooShort { .. })), "{error:?}");

    // Runs have to follow one another.
    let rows = DrivenRows::from(SampleRows::new(1, &[1.0, 2.0, 3.0]).unwrap());
    assert_eq!(rows.runs().collect::<Vec<_>>(), vec![0..3]);
    for starts in [&[0][..], &[3], &[2, 2], &[2, 1]] {
        assert!(matches!(rows.in_runs(starts), Err(RowsError::Start { .. })), "{starts:?}");
    }
}

/// One long log is as good as runs: it is cut into stretches that are long against its memory.
#[test]
fn a_long_log_is_cut_into_stretches() {
    let healthy = Runs::draw(60, 2);
    let log = Runs { starts: Vec::new(), ..Runs::draw(60, 2) };
    let wanted = FalseAlarms::PerSample { rate: 0.1 };
    for (record, runs) in [(&healthy, true), (&log, false)] {
        let (_, found) = calibrated(record, wanted, Evaluation::Magnitude, Beyond::Refuse).unwrap();
        println!("runs {runs}: {found:?}");
        assert!(found.block >= 5 && found.resolved_exceedances > 1.0 && !found.extrapolated);
    }
}
