//! From evidence to probabilities and a word.

use super::{
    answer::Answer,
    outlook::Outlook,
    rank::Ranking,
    result::{CauseId, Leftover, Pair, Verdict},
    settings::Settings,
};
use crate::evidence::probabilities;

/// Probability from which an answer is named.
const NAMED: f64 = 0.5;
/// Share of the amplitude of the gap from which what is left may be the work of something else;
/// less is the right mechanism with another law.
const OTHER: f64 = 0.15;

/// What a strength costs that the data know: an unknown cause has one as well.
const STRENGTH: f64 = 5.0;

/// Probabilities of the answers that exclude each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Judgement {
    pub(super) no_gap: f64,
    pub(super) none_of_these: f64,
}

/// Log-likelihood that something unknown could gain over the `best` explanation, which leaves
/// `left` and forecasts as `outlook` says. What forecasts well is the right mechanism; what
/// forecasts badly puts no more in doubt than it has gained.
pub(super) fn unknown_gain(best: &Answer, left: &Leftover, outlook: Outlook) -> f64 {
    let is_other = OTHER < left.share && !outlook.is_confirmed;
    let fitted = if is_other { left.gain() } else { 0.0 };
    fitted + outlook.loss.min(best.log_evidence.max(0.0))
}

/// Sets the probabilities of causes and pairs, and returns those of the other answers. Something
/// unknown, alone or beside the `best` explanation, could gain `gain`.
pub(super) fn judge(
    causes: &mut Ranking,
    pairs: &mut [Pair],
    best: &Answer,
    gain: f64,
    settings: &Settings,
) -> Judgement {
    let Settings { no_gap, unknown, two, temperature, .. } = *settings;
    let one = (1.0 - no_gap) * (1.0 - unknown - two);
    let share = |all: f64, n: usize| all / n.max(1) as f64;
    let each = share(one, causes.len());
    // Two causes out of n, of which only the promising ones were tried.
    let n = causes.len();
    let each_pair = share((1.0 - no_gap) * two, n * n.saturating_sub(1) / 2);
    let prior = [no_gap, each, each_pair][best.effects.min(2)] * unknown / (1.0 - unknown);
    let mut answers = vec![(0.0, no_gap), (best.log_evidence + gain - STRENGTH, prior)];
    answers.extend(causes.iter().map(|(_, cause)| (cause.log_evidence, each)));
    answers.extend(pairs.iter().map(|pair| (pair.log_evidence, each_pair)));
    let found = probabilities(&answers, temperature);
    let (causes_found, pairs_found) = found[2..].split_at(n);
    causes.iter_mut().zip(causes_found).for_each(|((_, c), p)| c.probability = *p);
    pairs.iter_mut().zip(pairs_found).for_each(|(pair, p)| pair.probability = *p);
    Judgement { no_gap: found[0], none_of_these: found[1] }
}

/// The answer in one word.
pub(super) fn verdict(
    judgement: Judgement,
    causes: &Ranking,
    tied: &[CauseId],
    pairs: &[Pair],
) -> Verdict {
    let probability = |id: &CauseId| causes.get(id.0).map(|(_, cause)| cause.probability);
    let single: f64 = tied.iter().filter_map(probability).sum();
    let double: f64 = pairs.iter().map(|pair| pair.probability).sum();
    if NAMED < judgement.no_gap || causes.is_empty() {
        Verdict::NoGap
    } else if NAMED < judgement.none_of_these {
        Verdict::NoneOfThese
    } else if NAMED < double {
        Verdict::Pair
    } else if NAMED < single {
        if tied.len() == 1 { Verdict::Cause } else { Verdict::Tied }
    } else {
        Verdict::Unclear
    }
}

/// Evidence from which a single cause out of `causes` is more probable than no gap.
pub(super) fn worth(settings: &Settings, causes: usize) -> f64 {
    let Settings { no_gap, unknown, two, temperature, .. } = *settings;
    let each = (1.0 - no_gap) * (1.0 - unknown - two) / causes.max(1) as f64;
    temperature * (no_gap / each).ln()
}
