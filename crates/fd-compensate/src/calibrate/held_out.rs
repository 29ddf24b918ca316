//! The threshold of a detector that is itself learned: judged on runs that it has not seen.

use std::ops::Range;

use fd_core::stage::Detector;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::{
    design::{
        Beyond, CalibratedThreshold, CalibrationPlan, FalseAlarms, LEAST_BLOCKS, automatic_block,
        check, longest_memory,
    },
    error::CalibrationError,
    statistics::statistics,
    tail::{predictive_tail, upper_quantile},
};
use crate::{count::whole, decide::Debouncing, rows::DrivenRows};

/// Parts that the record is dealt into; each is judged by a detector learned from the others.
const FOLDS: usize = 5;

/// A detector that `learn` makes from the fault-free record, and the threshold at which it keeps the wanted
/// rate of false alarms on *other* runs. The threshold that `learn` sets plays no part.
///
/// What a detector has learned fits the samples it has learned from better than any others, so
/// [`calibrate`](super::calibrate) on these samples promises too much. Here the runs are dealt into five parts,
/// or cut into five where they are fewer, and each part is judged by a detector learned from the other four
/// (cross-conformal prediction, Vovk 2015). What counts is a stretch: a run, or a piece of one that is long
/// against its memory. Of `n` stretches,
///
/// * [`FalseAlarms::PerRun`] takes the threshold that at most `probability (n + 1)` of their peaks
///   reach (Vovk, Gammerman & Shafer 2005, section 2.2);
/// * [`FalseAlarms::PerSample`] the smallest one with `Σ s_i + max s_i ≤ rate (n + 1)`, where `s_i` is the
///   share of stretch `i` above it: conformal risk control (Angelopoulos et al. 2024, eq. 4) with the worst
///   stretch so far in place of one that is lost altogether.
///
/// For stretches that are exchangeable with those to come, and up to the difference that a fifth of the data
/// makes to the detector, the rate on a fresh stretch is then at most the wanted one **on average over
/// records**, for `PerSample` but for what a stretch adds that is worse than all others, one in `n + 1`. That of
/// one record scatters, by the interval in the answer. With fewer than `1 / rate − 1` stretches the rate is
/// refused, or [extrapolated](Beyond::Extrapolate) with the predictive distribution of exponential excesses of
/// the peaks, which is cautious.
///
/// Detectors that look at the input need this too: in a record resampled in blocks the input jumps at each
/// seam, and the residual does not follow.
///
/// # Errors
///
/// Returns an error of `learn`, or as [`calibrate`](super::calibrate), or when there are too few stretches.
///
/// # Examples
///
/// ```
/// use fd_compensate::{
///     DrivenRows, SampleRows,
///     calibrate::{CalibrationError, CalibrationPlan, FalseAlarms, calibrate_held_out},
///     detect::{DetectorError, Magnitude},
/// };
///
/// #[derive(Debug)]
/// enum Failed {
///     Detector(DetectorError),
///     Calibration(CalibrationError),
/// }
/// impl From<CalibrationError> for Failed {
///     fn from(error: CalibrationError) -> Self {
///         Self::Calibration(error)
///     }
/// }
///
/// // Forty runs of fifty samples.
/// let healthy: Vec<f64> = (0..2000).map(|k| (f64::from(k).powi(2) * 0.618).sin()).collect();
/// let starts: Vec<usize> = (1..40).map(|run| 50 * run).collect();
/// let rows = DrivenRows::from(SampleRows::new(1, &healthy)?).in_runs(&starts)?;
/// // A scale that is learned: the mean magnitude.
/// let learn = |rows: DrivenRows<'_>| {
///     let mean = rows.residuals().iter().map(|r| r[0].abs()).sum::<f64>() / rows.len() as f64;
///     Magnitude::<f64>::new(&[mean], 1.0).map_err(Failed::Detector)
/// };
/// let wanted = FalseAlarms::PerRun { probability: 0.1, samples: 50 };
/// let (detector, found) =
///     calibrate_held_out(rows, wanted, &CalibrationPlan::default(), learn).unwrap();
/// let detector = detector.with_threshold(found.threshold)?;
/// assert!(!found.extrapolated);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn calibrate_held_out<D, E>(
    healthy: DrivenRows<'_>,
    wanted: FalseAlarms,
    plan: &CalibrationPlan,
    learn: impl Fn(DrivenRows<'_>) -> Result<D, E>,
) -> Result<(D, CalibratedThreshold), E>
where
    D: Detector<f64>,
    E: From<CalibrationError>,
{
    let mut detector = learn(healthy)?;
    check(&detector, healthy, wanted, plan)?;
    let samples = healthy.len();
    let mut seen: Vec<f64> = Vec::with_capacity(samples);
    for run in healthy.runs() {
        seen.extend(statistics(&mut detector, healthy, run, plan.debouncing));
    }
    detector.reset();
    // Minus infinity until the debouncing window holds enough samples.
    seen.retain(|s| s.is_finite());
    let memory = longest_memory(healthy.residuals(), &seen);
    // Whatever it remembers, a record does so within its runs.
    let longest_run = healthy.runs().map(|run| run.len()).max().unwrap_or(samples);
    let block = memory.map_or(longest_run, |time| automatic_block(plan, samples, time));
    let length = match wanted {
        FalseAlarms::PerSample { .. } => block,
        FalseAlarms::PerRun { samples: run, .. } => run.min(samples / LEAST_BLOCKS).max(block),
    };
    let mut stretches: Vec<Stretch> = parts(healthy)
        .flat_map(|(fold, part)| {
            pieces(part, length).map(move |of| Stretch { of, fold, values: Vec::new() })
        })
        .collect();
    let n = stretches.len();
    let independent: usize = healthy.runs().map(|run| (run.len() / length).max(1)).sum();
    if independent < LEAST_BLOCKS {
        let needed = LEAST_BLOCKS * length;
        let short = CalibrationError::TooShort { samples, block: length, needed };
        return Err(memory.map_or(CalibrationError::Drift { samples }, |_| short).into());
    }
    let rate = match wanted {
        FalseAlarms::PerSample { rate } => rate,
        FalseAlarms::PerRun { probability, samples: run } => {
            let share = samples as f64 / n as f64 / run as f64;
            // Stretches of a run alarm independently of one another.
            -((-probability).ln_1p() * share).exp_m1()
        }
    };
    let resolved_exceedances = expected_among(n, rate);
    let extrapolated = resolved_exceedances < 1.0;
    if extrapolated && plan.beyond == Beyond::Refuse {
        let needed = whole(rate.recip().ceil()) - 1;
        return Err(CalibrationError::TooFewStretches { rate, needed, found: n }.into());
    }
    judge(healthy, &mut stretches, plan.debouncing, learn)?;
    let rule = |of: &[&Stretch]| match wanted {
        FalseAlarms::PerSample { .. } => per_sample(of, rate),
        FalseAlarms::PerRun { .. } => per_run(of, rate),
    };
    let threshold = rule(&stretches.iter().collect::<Vec<_>>());
    let mut random = Xoshiro256PlusPlus::seed_from_u64(plan.seed);
    let mut resampled: Vec<f64> = (0..plan.records)
        .map(|_| {
            // Drawn as u64, so that the same seed means the same on every machine.
            let draw = |_| usize::try_from(random.random_range(0..n as u64)).unwrap_or(0);
            rule(&(0..n).map(draw).map(|i| &stretches[i]).collect::<Vec<_>>())
        })
        .collect();
    resampled.sort_unstable_by(f64::total_cmp);
    let tail = 0.5 * (1.0 - plan.confidence);
    let autocorrelation_time = memory.unwrap_or(length as f64);
    let found = CalibratedThreshold {
        threshold,
        low: upper_quantile(&resampled, 1.0 - tail).min(threshold),
        high: upper_quantile(&resampled, tail).max(threshold),
        confidence: plan.confidence,
        samples,
        autocorrelation_time,
        effective_samples: samples as f64 / autocorrelation_time,
        block: length,
        resolved_exceedances,
        extrapolated,
    };
    Ok((detector, found))
}

/// Samples within a run, judged by a detector that has not seen them.
struct Stretch {
    of: Range<usize>,
    fold: usize,
    /// The statistics in ascending order; those before the debouncing window holds enough samples are minus infinity.
    values: Vec<f64>,
}

impl Stretch {
    fn peak(&self) -> f64 {
        self.values[self.values.len() - 1]
    }

    fn share_above(&self, threshold: f64) -> f64 {
        let above = self.values.len() - self.values.partition_point(|v| *v <= threshold);
        above as f64 / self.values.len() as f64
    }
}

/// As many pieces of equal length, at least `length`, as a run holds; a shorter run is one piece.
fn pieces(run: Range<usize>, length: usize) -> impl Iterator<Item = Range<usize>> {
    let count = (run.len() / length.max(1)).max(1);
    let at = move |i: usize| run.start + i * run.len() / count;
    (0..count).map(move |i| at(i)..at(i + 1))
}

/// The parts of the record with the fold of each: whole runs, or contiguous parts of runs that are too few. Few
/// seams matter more than even folds: what remembers starts anew at each.
fn parts(healthy: DrivenRows<'_>) -> impl Iterator<Item = (usize, Range<usize>)> {
    let whole = healthy.runs().count() >= FOLDS;
    healthy.runs().enumerate().flat_map(move |(i, run)| {
        let length = if whole { run.len() } else { run.len() / FOLDS };
        pieces(run, length).enumerate().map(move |(j, part)| ((i + j) % FOLDS, part))
    })
}

/// Judges each stretch by a detector learned from the other folds.
fn judge<D: Detector<f64>, E>(
    healthy: DrivenRows<'_>,
    stretches: &mut [Stretch],
    debouncing: Debouncing,
    learn: impl Fn(DrivenRows<'_>) -> Result<D, E>,
) -> Result<(), E> {
    for fold in 0..FOLDS {
        let others = stretches.iter().filter(|stretch| stretch.fold != fold);
        let mut detector = learn(healthy.select(others.map(|stretch| &stretch.of)).rows())?;
        for run in healthy.runs() {
            let own = |of: &Range<usize>| run.start <= of.start && of.end <= run.end;
            let mut held = stretches.iter_mut().filter(|s| s.fold == fold && own(&s.of)).peekable();
            if held.peek().is_none() {
                continue;
            }
            // From the beginning of the run, as in use.
            let values = statistics(&mut detector, healthy, run.clone(), debouncing);
            for stretch in held {
                let own = stretch.of.start - run.start..stretch.of.end - run.start;
                stretch.values = values[own].to_vec();
                stretch.values.sort_unstable_by(f64::total_cmp);
            }
        }
    }
    Ok(())
}

/// How many of `n` stretches and a fresh one are expected to exceed the threshold; the small excess undoes
/// the rounding of a rate that makes it a whole number.
fn expected_among(n: usize, rate: f64) -> f64 {
    rate * (n + 1) as f64 * (1.0 + 1e-12)
}

/// The threshold that a fresh stretch exceeds with at most this probability.
fn per_run(stretches: &[&Stretch], probability: f64) -> f64 {
    let mut peaks: Vec<f64> = stretches.iter().map(|stretch| stretch.peak()).collect();
    peaks.sort_unstable_by(f64::total_cmp);
    let n = peaks.len();
    match whole(expected_among(n, probability)) {
        0 => predictive_tail(&peaks, probability),
        reached => peaks[n - reached.min(n)],
    }
}

/// The threshold that at most this share of the samples of a fresh stretch exceeds, on average.
fn per_sample(stretches: &[&Stretch], rate: f64) -> f64 {
    let allowed = expected_among(stretches.len(), rate);
    if allowed >= 1.0 {
        return with_one_more(stretches, allowed);
    }
    let mut peaks: Vec<f64> = stretches.iter().map(|stretch| stretch.peak()).collect();
    peaks.sort_unstable_by(f64::total_cmp);
    // A stretch that exceeds a higher threshold at all does so for a smaller part.
    let foot = predictive_tail(&peaks, 1.0);
    let share = |of: &&Stretch| of.share_above(foot);
    let loud = stretches.iter().map(share).filter(|share| *share > 0.0);
    let (sum, count) = loud.fold((0.0, 0.0), |(sum, count), share| (sum + share, count + 1.0));
    if count <= 0.0 { foot } else { predictive_tail(&peaks, rate * count / sum) }
}

/// The smallest value above which the shares of all stretches and once more the largest of them add up to no
/// more than `allowed`.
fn with_one_more(stretches: &[&Stretch], allowed: f64) -> f64 {
    let mut all: Vec<(f64, usize)> = (0..)
        .zip(stretches)
        .flat_map(|(i, stretch)| stretch.values.iter().map(move |&value| (value, i)))
        .collect();
    all.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
    let mut above = vec![0_usize; stretches.len()];
    let (mut sum, mut most, mut smallest) = (0.0, 0.0_f64, f64::INFINITY);
    for level in all.chunk_by(|a, b| a.0.total_cmp(&b.0).is_eq()) {
        if sum + most > allowed {
            break;
        }
        smallest = level[0].0;
        for &(_, i) in level {
            above[i] += 1;
            let samples = stretches[i].values.len() as f64;
            sum += samples.recip();
            most = most.max(above[i] as f64 / samples);
        }
    }
    smallest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::SampleRows;

    #[test]
    fn shares_add_up_with_the_largest_once_more() {
        let stretch = |values: &[f64]| Stretch { of: 0..1, fold: 0, values: values.to_vec() };
        let all = [stretch(&[1.0, 2.0, 5.0, 6.0]), stretch(&[1.0, 4.0])];
        let of: Vec<&Stretch> = all.iter().collect();
        // Above 5 lies a quarter of the first, above 4 half of it, above 2 half of the second too, above 1
        // three quarters and one half.
        for (allowed, expected) in
            [(0.4, 6.0), (0.6, 5.0), (1.1, 4.0), (1.6, 2.0), (2.1, 1.0), (3.0, 1.0)]
        {
            let found = with_one_more(&of, allowed);
            assert!((found - expected).abs() < f64::EPSILON, "{allowed}: {found}");
        }
    }

    /// Five of ten peaks lie above their median 5, by 3 on average, and 0.4 of the samples of these stretches do: the
    /// rate 0.01 of samples is 0.025 of stretches, of which 6 in 11 exceed the median.
    #[test]
    fn a_rate_beyond_the_stretches_counts_the_loud_part_of_them() {
        let stretch = |(peak, loud): (u8, usize)| {
            let values = (0..20).map(|i| if i < 20 - loud { 0.0 } else { f64::from(peak) });
            Stretch { of: 0..1, fold: 0, values: values.collect() }
        };
        let all = (1..=10).zip([1, 2, 3, 4, 5, 10, 10, 5, 5, 10]).map(stretch).collect::<Vec<_>>();
        let found = per_sample(&all.iter().collect::<Vec<_>>(), 0.01);
        let expected = 5.0 + 5.0 * 3.0 * ((6.0_f64 / 11.0 / 0.025).powf(0.2) - 1.0);
        assert!((found - expected).abs() < 1e-12 * expected, "{found} {expected}");
    }

    #[test]
    fn runs_are_cut_evenly() {
        let cut = |run, length| pieces(run, length).collect::<Vec<_>>();
        assert_eq!(cut(10..20, 3), [10..13, 13..16, 16..20]);
        assert_eq!(cut(10..20, 30), vec![10..20]);
        let values = [0.0; 23];
        let rows = DrivenRows::from(SampleRows::new(1, &values).unwrap());
        let folds: Vec<_> = parts(rows).collect();
        assert_eq!(folds, [(0, 0..4), (1, 4..9), (2, 9..13), (3, 13..18), (4, 18..23)]);
        let starts = [3, 6, 9, 12, 15];
        let folds: Vec<_> = parts(rows.in_runs(&starts).unwrap()).map(|(fold, _)| fold).collect();
        assert_eq!(folds, [0, 1, 2, 3, 4, 0]);
    }
}
