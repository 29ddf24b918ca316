//! The gap over time: where does it begin?

use fd_compensate::calibrate::autocorrelation_time;
use fd_numeric::rms;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::{
    bench::{Bench, Rows},
    result::{Change, Stretch, TimeCourse},
};
use crate::diagnose::Diagnosis;

/// Stretches per log.
const STRETCHES: usize = 12;
/// Blocks in which a change is looked for.
const BLOCKS: usize = 64;
/// Fewest samples of a block.
const FEWEST_SAMPLES: usize = 5;
/// Blocks are this many autocorrelation times long, if that leaves enough blocks …
const MEMORIES: f64 = 4.0;
/// … and these are enough.
const ENOUGH_BLOCKS: usize = 24;
/// Permutations.
const PERMUTATIONS: usize = 199;
/// Probability of a false change in any log.
const FALSE_CLAIMS: f64 = 0.05;
/// Ratio of the gaps inside and outside from which a change matters.
const MATTERS: f64 = 1.5;
const SEED: u64 = 0x71_4E5;

/// Gaps over time; `before` and `after` are residuals in sigma per output and log.
pub(super) fn times(
    bench: &Bench,
    diagnosis: &Diagnosis,
    before: &[Rows],
    after: &[Rows],
) -> Vec<TimeCourse> {
    let floor = (diagnosis.floor.iter().map(|f| f * f).sum::<f64>() / bench.ny() as f64).sqrt();
    let logs = bench.logs.len();
    let course = |log: usize| {
        let n = bench.logs[log].samples;
        let gap = |residuals: &[Rows], from: usize, to: usize| {
            let values = residuals.iter().flat_map(|output| &output[log][from..to]);
            let mut finite = values.copied().filter(|v| v.is_finite()).peekable();
            finite.peek().is_some().then(|| rms(finite))
        };
        let pieces = STRETCHES.min(n);
        let stretches = (0..pieces).filter_map(|i| {
            let (from, to) = (i * n / pieces, (i + 1) * n / pieces);
            Some(Stretch {
                from: from as f64 * bench.ts(),
                to: to as f64 * bench.ts(),
                refit: gap(before, from, to)?,
                after: gap(after, from, to)?,
            })
        });
        let stretches: Vec<Stretch> = stretches.collect();
        let memory = before.iter().map(|output| {
            let signal: Vec<f64> = output[log].iter().copied().filter(|v| v.is_finite()).collect();
            autocorrelation_time(&signal).unwrap_or(n as f64)
        });
        let memory = memory.fold(1.0, f64::max);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive")]
        let blocks = ((n as f64 / (MEMORIES * memory)) as usize).clamp(ENOUGH_BLOCKS, BLOCKS);
        let limit = |i: usize| i * n / blocks;
        let sizes: Option<Vec<f64>> = (FEWEST_SAMPLES * blocks <= n)
            .then(|| (0..blocks).map(|b| gap(before, limit(b), limit(b + 1))).collect())
            .flatten();
        let change = sizes.and_then(|sizes| {
            let found = arc(&sizes, floor, SEED + log as u64)?;
            let inside = gap(before, limit(found.from), limit(found.to))?;
            let outer = [(0, found.from), (found.to, blocks)];
            let squares = outer.iter().filter(|(a, b)| a < b).filter_map(|&(a, b)| {
                let size = gap(before, limit(a), limit(b))?;
                Some([(b - a) as f64 * size * size, (b - a) as f64])
            });
            let [sum, count] = squares.fold([0.0; 2], |s, v| [s[0] + v[0], s[1] + v[1]]);
            let outside = f64::sqrt(sum / count.max(1.0));
            let ratio = (inside / outside).max(outside / inside);
            let is_real = found.p_value <= FALSE_CLAIMS / logs as f64 && MATTERS < ratio;
            is_real.then_some(Change {
                from: limit(found.from) as f64 * bench.ts(),
                to: limit(found.to) as f64 * bench.ts(),
                inside,
                outside,
                p_value: found.p_value,
            })
        });
        let duration = n as f64 * bench.ts();
        let statement = words(log, logs, duration, change.as_ref());
        TimeCourse { log, stretches, change, statement }
    };
    (0..logs).map(course).collect()
}

/// Consecutive blocks that differ from the others.
struct Arc {
    from: usize,
    to: usize,
    p_value: f64,
}

/// The consecutive blocks whose gap differs most from the others (circular binary segmentation of
/// the logarithms, Olshen et al. 2004), with the probability of such a difference when blocks are
/// in any order. Of an arc and its complement, the one that ends with the log or does not contain
/// its start.
fn arc(sizes: &[f64], floor: f64, seed: u64) -> Option<Arc> {
    // Below the floor differences are of no interest.
    let mut logs: Vec<f64> = sizes.iter().map(|size| size.max(0.5 * floor).ln()).collect();
    let (observed, from, to) = strongest(&logs)?;
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut as_strong = 1.0;
    for _ in 0..PERMUTATIONS {
        for i in (1..logs.len()).rev() {
            // Drawn as u64, so that the same seed means the same on every machine.
            let j = usize::try_from(random.random_range(0..=i as u64)).unwrap_or(0);
            logs.swap(i, j);
        }
        if strongest(&logs).is_some_and(|(strength, ..)| observed <= strength) {
            as_strong += 1.0;
        }
    }
    let p_value = as_strong / (PERMUTATIONS + 1) as f64;
    // "From the start until 5 s" is "from 5 s to the end" of the complement.
    let (from, to) = if from == 0 { (to, sizes.len()) } else { (from, to) };
    Some(Arc { from, to, p_value })
}

/// Largest standardised difference between an arc and its complement.
fn strongest(values: &[f64]) -> Option<(f64, usize, usize)> {
    let n = values.len();
    let total: f64 = values.iter().sum();
    let mean = total / n as f64;
    let mut best: Option<(f64, usize, usize)> = None;
    for from in 0..n {
        let mut sum = 0.0;
        for to in from + 1..=n {
            sum += values[to - 1] - mean;
            let inside = (to - from) as f64;
            let outside = n as f64 - inside;
            if outside < 1.0 {
                continue;
            }
            let strength = sum * sum * (1.0 / inside + 1.0 / outside);
            if best.is_none_or(|(known, ..)| known < strength) {
                best = Some((strength, from, to));
            }
        }
    }
    best.filter(|(strength, ..)| 0.0 < *strength)
}

fn words(log: usize, logs: usize, duration: f64, change: Option<&Change>) -> String {
    use super::channels::Short;

    let which = if logs == 1 { String::new() } else { format!("log {}: ", log + 1) };
    let Some(change) = change else {
        return format!("{which}the size of the gap does not change significantly over time");
    };
    let Change { from, to, inside, outside, .. } = *change;
    let seconds = |s: f64| format!("{:.3} s", Short(s));
    let when = if to < duration * (1.0 - 1e-9) {
        format!("from {} to {}", seconds(from), seconds(to))
    } else {
        format!("from {} on", seconds(from))
    };
    let (times, how) =
        if outside < inside { (inside / outside, "larger") } else { (outside / inside, "smaller") };
    format!("{which}{when} the gap is {times:.1} times {how} than in the rest of the log")
}
