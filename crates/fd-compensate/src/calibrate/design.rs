//! From a fault-free record and a wanted false-alarm rate to a threshold with an interval.

use fd_core::stage::Detector;
use serde::{Deserialize, Serialize};

use super::{
    autocorrelation::autocorrelation_time,
    beginning,
    bootstrap::CircularBlocks,
    error::{CalibrationError, LEAST_EXCEEDANCES},
    statistics::statistics,
    tail::{Tail, exponential_tail, upper_quantile},
};
use crate::{
    count::whole,
    decide::Debouncing,
    rows::{DrivenRows, SampleRows},
};

/// How often an alarm may be false.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum FalseAlarms {
    /// Share of healthy samples at which the raise condition holds.
    PerSample {
        /// That share, between 0 and 1.
        rate: f64,
    },
    /// Probability of any alarm in a healthy run.
    PerRun {
        /// That probability, between 0 and 1.
        probability: f64,
        /// Length of the run in samples.
        samples: usize,
    },
}

/// What to do with a rate that the record cannot resolve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Beyond {
    /// Return an error.
    #[default]
    Refuse,
    /// Continue with an exponential tail, and say so in the answer.
    Extrapolate,
}

/// Choices of the calibration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CalibrationPlan {
    /// Seed of all resampling; default 1992.
    pub seed: u64,
    /// Resampled runs behind a threshold per run; default 400.
    pub runs: usize,
    /// Resampled records behind the interval; default 60.
    pub records: usize,
    /// Probability that the interval covers; default 0.9.
    pub confidence: f64,
    /// Block length in samples; default five integrated autocorrelation times, and at least the cube
    /// root of the number of samples.
    pub block: Option<usize>,
    /// The raise condition that the rule will use; default every sample for itself.
    pub debouncing: Debouncing,
    /// What to do with a rate that the record cannot resolve; default refuse.
    pub beyond: Beyond,
}

impl Default for CalibrationPlan {
    fn default() -> Self {
        Self {
            seed: 1992,
            runs: 400,
            records: 60,
            confidence: 0.9,
            block: None,
            debouncing: Debouncing::default(),
            beyond: Beyond::default(),
        }
    }
}

/// A threshold with what it rests on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CalibratedThreshold {
    /// The threshold, in the unit of the detector's statistic.
    pub threshold: f64,
    /// Lower end of its interval.
    pub low: f64,
    /// Upper end of its interval.
    pub high: f64,
    /// Probability that the interval covers.
    pub confidence: f64,
    /// Fault-free samples.
    pub samples: usize,
    /// Integrated autocorrelation time in samples, the longest of residual channels and statistic.
    pub autocorrelation_time: f64,
    /// Independent samples that the record is worth.
    pub effective_samples: f64,
    /// Block length in samples.
    pub block: usize,
    /// Independent exceedances that the record is expected to hold.
    pub resolved_exceedances: f64,
    /// Whether the threshold lies on a fitted tail beyond what the record resolves.
    pub extrapolated: bool,
}

/// Fewest blocks in a record.
pub(super) const LEAST_BLOCKS: usize = 10;

/// Finds the threshold at which `detector` keeps the wanted rate of false alarms on records like
/// `healthy`; the threshold that the detector has plays no part. The detector is left reset.
///
/// A detector that looks at the input needs a record that has it, [`DrivenRows`]; for the others
/// [`SampleRows`](crate::SampleRows) of the residual are enough.
///
/// # Errors
///
/// Returns an error when channels differ, a number is out of range, the record is too short or drifts,
/// or cannot resolve the rate.
///
/// # Examples
///
/// ```
/// use fd_compensate::{
///     SampleRows,
///     calibrate::{CalibrationPlan, FalseAlarms, calibrate},
///     detect::Magnitude,
/// };
///
/// // A pseudo-random sequence on (-1, 1) that is uniform and hardly correlated.
/// let healthy: Vec<f64> = (0..5000).map(|k| (f64::from(k).powi(2) * 0.618).sin()).collect();
/// let mut detector = Magnitude::new(&[1.0], 1.0)?;
/// let wanted = FalseAlarms::PerSample { rate: 0.01 };
/// let rows = SampleRows::new(1, &healthy)?;
/// let found = calibrate(&mut detector, rows, wanted, &CalibrationPlan::default())?;
/// assert!(found.low <= found.threshold && found.threshold <= found.high);
/// let detector = detector.with_threshold(found.threshold)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn calibrate<'a, D: Detector<f64> + ?Sized>(
    detector: &mut D,
    healthy: impl Into<DrivenRows<'a>>,
    wanted: FalseAlarms,
    plan: &CalibrationPlan,
) -> Result<CalibratedThreshold, CalibrationError> {
    calibrate_with_beginnings(detector, healthy.into(), None, wanted, plan)
}

/// As [`calibrate`], for runs that begin as one of `beginnings`, each a run of its own: what a start leaves in the
/// residual, such as the noise in the first past values of a bias model, is no part of a long record, or one part of
/// it. A rate per sample is that of the record.
///
/// ```
/// use fd_compensate::{
///     DrivenRows, SampleRows,
///     calibrate::{Beyond, CalibrationPlan, FalseAlarms, calibrate_with_beginnings},
///     detect::Magnitude,
/// };
///
/// let healthy: Vec<f64> = (0..5000).map(|k| (f64::from(k).powi(2) * 0.618).sin()).collect();
/// let mut detector = Magnitude::new(&[1.0], 1.0)?;
/// let wanted = FalseAlarms::PerRun { probability: 0.1, samples: 500 };
/// let plan = CalibrationPlan { beyond: Beyond::Extrapolate, ..CalibrationPlan::default() };
/// let rows = |values| SampleRows::new(1, values).map(DrivenRows::from);
/// let mut threshold = |beginnings| {
///     calibrate_with_beginnings(&mut detector, rows(&healthy)?, beginnings, wanted, &plan)
///         .map(|found| found.threshold)
///         .map_err(Box::<dyn std::error::Error>::from)
/// };
/// // Twenty runs begin with a value between two and four.
/// let loud: Vec<f64> = (0..40).map(|k| f64::from(k % 2 * (40 + k)) / 20.0).collect();
/// let starts: Vec<usize> = (1..20).map(|run| 2 * run).collect();
/// let loud = rows(&loud)?.in_runs(&starts)?;
/// assert!(threshold(None)? < 1.1 && threshold(Some(loud))? > 3.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// As [`calibrate`]; beginnings have the channels of the record.
pub fn calibrate_with_beginnings<D: Detector<f64> + ?Sized>(
    detector: &mut D,
    healthy: DrivenRows<'_>,
    beginnings: Option<DrivenRows<'_>>,
    wanted: FalseAlarms,
    plan: &CalibrationPlan,
) -> Result<CalibratedThreshold, CalibrationError> {
    check(detector, healthy, wanted, plan)?;
    if let Some(beginnings) = beginnings {
        check(detector, beginnings, wanted, plan)?;
    }
    let samples = healthy.len();
    let mut statistics = statistics(detector, healthy, 0..samples, plan.debouncing);
    // Minus infinity until the debouncing window holds enough samples.
    statistics.retain(|s| s.is_finite());
    let Some(time) = longest_memory(healthy.residuals(), &statistics) else {
        return Err(CalibrationError::Drift { samples });
    };
    let block = block_length(plan, samples, time)?;
    let effective_samples = samples as f64 / time;
    let resolved_exceedances = match wanted {
        FalseAlarms::PerSample { rate } => rate * effective_samples,
        FalseAlarms::PerRun { probability, samples: run } => {
            -(-probability).ln_1p() * samples as f64 / run as f64
        }
    };
    let extrapolated = resolved_exceedances < LEAST_EXCEEDANCES;
    if extrapolated && plan.beyond == Beyond::Refuse {
        let needed = whole((samples as f64 * LEAST_EXCEEDANCES / resolved_exceedances).ceil());
        let expected_exceedances = resolved_exceedances;
        return Err(CalibrationError::Unresolved { expected_exceedances, samples, needed });
    }
    let begun = beginnings.map(|of| beginning::peaks(detector, of, plan.debouncing));
    let question = Question { wanted, plan, block, effective_samples, extrapolated, begun };
    let whole: Vec<usize> = (0..samples).collect();
    let threshold = question.threshold(detector, healthy, &whole, plan.seed);
    let mut resampled: Vec<f64> = (1..=plan.records as u64)
        .map(|record| {
            // Seeds of records and of the runs within them must not coincide.
            let seed = plan.seed.wrapping_add(record.wrapping_mul(0x9E37_79B9_7F4A_7C15));
            let drawn: Vec<usize> =
                CircularBlocks::new(samples, block, seed).take(samples).collect();
            question.threshold(detector, healthy, &drawn, !seed)
        })
        .collect();
    resampled.sort_unstable_by(f64::total_cmp);
    detector.reset();
    let tail = 0.5 * (1.0 - plan.confidence);
    Ok(CalibratedThreshold {
        threshold,
        low: upper_quantile(&resampled, 1.0 - tail).min(threshold),
        high: upper_quantile(&resampled, tail).max(threshold),
        confidence: plan.confidence,
        samples,
        autocorrelation_time: time,
        effective_samples,
        block,
        resolved_exceedances,
        extrapolated,
    })
}

/// What is asked of every record, original or resampled.
struct Question<'a> {
    wanted: FalseAlarms,
    plan: &'a CalibrationPlan,
    block: usize,
    effective_samples: f64,
    extrapolated: bool,
    /// The largest statistic of each beginning, ascending.
    begun: Option<Vec<f64>>,
}

impl Question<'_> {
    /// The threshold for the record made of the samples `drawn` from `healthy`.
    fn threshold<D: Detector<f64> + ?Sized>(
        &self,
        detector: &mut D,
        healthy: DrivenRows<'_>,
        drawn: &[usize],
        seed: u64,
    ) -> f64 {
        let debouncing = self.plan.debouncing;
        match self.wanted {
            FalseAlarms::PerSample { rate } => {
                let mut values = statistics(detector, healthy, drawn.iter().copied(), debouncing);
                values.sort_unstable_by(f64::total_cmp);
                if self.extrapolated {
                    let resolved = (4.0 * LEAST_EXCEEDANCES / self.effective_samples).min(0.5);
                    exponential_tail(&values, resolved, rate)
                } else {
                    upper_quantile(&values, rate)
                }
            }
            FalseAlarms::PerRun { probability, samples } => {
                // A run that the record holds often enough; the rest is Poisson.
                let longest = (drawn.len() / LEAST_BLOCKS).max(1);
                let length = if self.extrapolated { samples.min(longest) } else { samples };
                let mut blocks = CircularBlocks::new(drawn.len(), self.block, seed);
                let mut maxima: Vec<f64> = (0..self.plan.runs)
                    .map(|_| {
                        blocks.restart();
                        let run = blocks.by_ref().take(length).map(|i| drawn[i]);
                        let values = statistics(detector, healthy, run, debouncing);
                        values.into_iter().fold(f64::NEG_INFINITY, f64::max)
                    })
                    .collect();
                maxima.sort_unstable_by(f64::total_cmp);
                let share = length as f64 / samples as f64;
                let rate = -((-probability).ln_1p() * share).exp_m1();
                let resolved = if self.extrapolated { rate.max(0.5) } else { probability };
                if let Some(begun) = &self.begun {
                    let rest = Tail { sorted: &maxima, resolved };
                    beginning::threshold(begun, &rest, share.recip(), probability)
                } else if self.extrapolated {
                    exponential_tail(&maxima, resolved, rate)
                } else {
                    upper_quantile(&maxima, probability)
                }
            }
        }
    }
}

/// The longest autocorrelation time of residual channels and statistic; `None` when one does not decay.
pub(super) fn longest_memory(residuals: SampleRows<'_>, statistics: &[f64]) -> Option<f64> {
    (0..residuals.channels())
        .map(|channel| autocorrelation_time(&residuals.channel(channel).collect::<Vec<_>>()))
        .chain([autocorrelation_time(statistics)])
        .try_fold(1.0, |worst: f64, time| Some(worst.max(time?)))
}

/// Samples that are long against a memory.
pub(super) fn automatic_block(plan: &CalibrationPlan, samples: usize, time: f64) -> usize {
    plan.block.unwrap_or(whole((5.0 * time).max((samples as f64).cbrt()).ceil()))
}

fn block_length(
    plan: &CalibrationPlan,
    samples: usize,
    time: f64,
) -> Result<usize, CalibrationError> {
    let block = automatic_block(plan, samples, time);
    let needed = LEAST_BLOCKS * block;
    if samples < needed {
        return Err(CalibrationError::TooShort { samples, block, needed });
    }
    Ok(block)
}

pub(super) fn check<D: Detector<f64> + ?Sized>(
    detector: &D,
    healthy: DrivenRows<'_>,
    wanted: FalseAlarms,
    plan: &CalibrationPlan,
) -> Result<(), CalibrationError> {
    let (expected, found) = (detector.residual_len(), healthy.residuals().channels());
    if expected != found {
        return Err(CalibrationError::Channels { expected, found });
    }
    if let Some(expected) = detector.nu().filter(|&nu| nu != healthy.nu()) {
        return Err(CalibrationError::Inputs { expected, found: healthy.nu() });
    }
    plan.debouncing.check()?;
    let (rate, run) = match wanted {
        FalseAlarms::PerSample { rate } => (rate, 1),
        FalseAlarms::PerRun { probability, samples } => (probability, samples),
    };
    for (parameter, found) in [("false-alarm rate", rate), ("confidence", plan.confidence)] {
        if !(found > 0.0 && found < 1.0) {
            let expected = "between 0 and 1";
            return Err(CalibrationError::Parameter { parameter, expected, found });
        }
    }
    let counts = [
        ("run length", run),
        ("runs", plan.runs),
        ("records", plan.records),
        ("block", plan.block.unwrap_or(1)),
    ];
    match counts.into_iter().find(|&(_, count)| count == 0) {
        Some((parameter, _)) => {
            Err(CalibrationError::Parameter { parameter, expected: "at least 1", found: 0.0 })
        }
        None => Ok(()),
    }
}
