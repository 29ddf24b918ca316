//! Does an input respond to the noise of the outputs?
//!
//! In a loop the command is computed from the measurement, noise included. Noise is what the past does not
//! predict, so both sides are reduced to that: the errors of a model to the part that neither past errors nor
//! the input predict, the input to the part that its own past does not predict (as in a test of Granger
//! causality, *Econometrica* 37, 1969). In open loop the two are independent, whatever the model lacks: its
//! errors then follow from the input.
//!
//! Ranks are correlated, not values, so that a few large steps of a reference do not dominate.
//!
//! *When not to use:* to say that there is no loop. A controller that acts slowly, or on little noise, leaves
//! too little to be detected.

use fd_numeric::dot;

use super::pattern::remove;

/// Past samples that foretell.
const PAST: usize = 8;
/// Largest delay of an answer, in samples.
const LATEST: usize = 20;
/// Correlation, in standard deviations of that of independent signals, that speaks for feedback.
const SURE: f64 = 5.0;
/// Least correlation that matters.
const LEAST: f64 = 0.12;
/// Fewest rows that say anything.
const FEWEST: usize = 40;

/// The largest rank correlation of an `input` with errors of the sample `earliest` samples before or earlier,
/// if chance does not explain it. `errors` (measured less simulated, or the other way) belong to an output that
/// shows the input `earliest` samples later at the soonest, as far as is known: 0 for one after the
/// next sample, 1 for one that passes the input on at once.
///
/// ```
/// use fd_gap::quality::feedback;
///
/// // Noise, a command of its own, and one that answers the noise.
/// let noise = |k: usize| ((k * 7919 + 5) % 101) as f64 / 50.0 - 1.0;
/// let reference = |k: usize| ((k / 7 * 31) % 17) as f64 / 8.0 - 1.0;
/// let errors: Vec<f64> = (0..600).map(noise).collect();
/// let alone: Vec<f64> = (0..600).map(reference).collect();
/// let answers: Vec<f64> = (0..600).map(|k| 0.5 * (reference(k) - noise(k))).collect();
/// assert!(feedback(&alone, &errors, 0).is_none());
/// assert!(feedback(&answers, &errors, 0).is_some_and(|correlation| correlation < -0.3));
/// ```
#[must_use]
pub fn feedback(input: &[f64], errors: &[f64], earliest: usize) -> Option<f64> {
    let n = input.len().min(errors.len());
    let first = PAST + LATEST;
    if n <= first + FEWEST {
        return None;
    }
    let past = |signal: &[f64], delay: usize| -> Vec<f64> {
        (0..n).map(|k| if delay <= k { signal[k - delay] } else { f64::NAN }).collect()
    };
    let delays = |signal: &[f64]| (1..=PAST).map(|delay| past(signal, delay)).collect::<Vec<_>>();
    let of_input = unforeseen(&input[..n], &delays(input));
    let of_errors = unforeseen(&errors[..n], &[delays(input), delays(errors)].concat());
    let moves = |k: &usize| input[*k].to_bits() != input[*k - 1].to_bits();
    // A command that is held most of the time answers only where it moves.
    let moved: Vec<usize> = (first..n).filter(moves).collect();
    let rows: Vec<usize> = if 2 * moved.len() < n - first { moved } else { (first..n).collect() };
    let correlation = |delay: usize| {
        let pairs = rows.iter().map(|k| (of_input[*k], of_errors[*k - delay]));
        let pairs: Vec<(f64, f64)> =
            pairs.filter(|(u, e)| u.is_finite() && e.is_finite()).collect();
        let m = pairs.len();
        if m < FEWEST {
            return None;
        }
        let ranks =
            |side: &dyn Fn(&(f64, f64)) -> f64| ranks(&pairs.iter().map(side).collect::<Vec<_>>());
        let (u, e) = (ranks(&|pair| pair.0), ranks(&|pair| pair.1));
        let size = f64::sqrt(dot(&u, &u) * dot(&e, &e));
        let found = dot(&u, &e) / size;
        let limit = LEAST.max(SURE / f64::sqrt(m as f64));
        (limit < found.abs()).then_some(found)
    };
    (earliest..=LATEST).filter_map(correlation).max_by(|a, b| a.abs().total_cmp(&b.abs()))
}

/// What a signal has that `columns` and a constant do not foretell; NaN where something is missing.
fn unforeseen(signal: &[f64], columns: &[Vec<f64>]) -> Vec<f64> {
    let is_whole = |k: &usize| signal[*k].is_finite() && columns.iter().all(|c| c[*k].is_finite());
    let rows: Vec<usize> = (0..signal.len()).filter(is_whole).collect();
    let pick = |values: &[f64]| -> Vec<f64> { rows.iter().map(|k| values[*k]).collect() };
    let mut left = pick(signal);
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(columns.len() + 1);
    let constant = vec![1.0; rows.len()];
    for mut column in std::iter::once(constant).chain(columns.iter().map(|c| pick(c))) {
        let before = dot(&column, &column);
        // Twice is enough (Kahan, in Parlett 1980).
        for unit in basis.iter().chain(&basis) {
            remove(unit, &mut column);
        }
        let after = dot(&column, &column);
        if 1e-12 * before < after {
            let size = after.sqrt();
            for v in &mut column {
                *v /= size;
            }
            remove(&column, &mut left);
            basis.push(column);
        }
    }
    let mut all = vec![f64::NAN; signal.len()];
    for (k, value) in rows.iter().zip(left) {
        all[*k] = value;
    }
    all
}

/// Ranks about their mean; equal values share theirs.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let middle = 0.5 * (values.len() as f64 - 1.0);
    let mut ranks = vec![0.0; values.len()];
    let mut from = 0;
    for group in order.chunk_by(|a, b| values[*a].total_cmp(&values[*b]).is_eq()) {
        let rank = from as f64 + 0.5 * (group.len() as f64 - 1.0) - middle;
        for k in group {
            ranks[*k] = rank;
        }
        from += group.len();
    }
    ranks
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn random(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        move || {
            // The sum of uniform numbers is nearly Gaussian.
            let mut sum = 0.0;
            for _ in 0..4 {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                sum += (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
            }
            sum
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// A friction that the model lacks, in open loop: an error of the model follows from the input, and 21
        /// correlations beyond five standard deviations are a matter of one log in 80 000.
        #[test]
        fn an_open_loop_is_none(seed in 1_u64..10_000, held in 1_usize..30) {
            let mut random = random(seed);
            let (mut u, mut x) = (0.0, 0.0_f64);
            let (mut input, mut errors) = (Vec::new(), Vec::new());
            for k in 0..800 {
                if k % held == 0 {
                    u = 3.0 * random();
                }
                input.push(u);
                errors.push(0.3 * x.signum() * x.abs().sqrt() + 0.05 * random());
                x = 0.9 * x + 0.1 * u;
            }
            prop_assert!(feedback(&input, &errors, 0).is_none());
        }

        /// A proportional controller on the measurement, with a reference in steps.
        #[test]
        fn a_loop_is_one(seed in 1_u64..10_000, gain in 0.3..3.0) {
            let mut random = random(seed);
            let (mut x, mut reference) = (0.0, 0.0);
            let (mut input, mut errors) = (Vec::new(), Vec::new());
            for k in 0..800 {
                if k % 60 == 0 {
                    reference = 3.0 * random();
                }
                let noise = 0.2 * random();
                let u = gain * (reference - x - noise);
                input.push(u);
                errors.push(noise);
                x += 0.1 * (u - x);
            }
            prop_assert!(feedback(&input, &errors, 0).is_some());
        }
    }

    #[test]
    fn equal_values_share_a_rank() {
        assert_eq!(ranks(&[5.0, 1.0, 5.0, 2.0]), [1.0, -1.5, 1.0, -0.5]);
    }
}
