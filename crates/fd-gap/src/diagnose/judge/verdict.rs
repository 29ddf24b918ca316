//! The answer in one word.

use super::{
    judged::{NamedPairs, Ties},
    probabilities::Probabilities,
};
use crate::diagnose::{
    result::{Pair, Verdict},
    weigh::rank::RankedCause,
};

/// Probability from which an answer is named.
const NAMED: f64 = 0.5;

/// The answer in one word. What has more than half of the probability is named; tied causes have it
/// together, and so have pairs. A cause that is at work with that probability, alone or as one of two, is named even where
/// it is open whether there is a second one, and which.
pub(super) fn verdict(
    probabilities: Probabilities,
    causes: &[RankedCause],
    Ties { tied, .. }: &Ties,
    NamedPairs { pairs, .. }: &NamedPairs,
) -> Verdict {
    let tied_causes = tied.iter().filter_map(|id| causes.get(id.0));
    let single: f64 = tied_causes.map(|ranked| ranked.cause.probability).sum();
    let is_one_of = |pair: &&Pair| {
        let mut tied = tied.iter().filter_map(|id| causes.get(id.0));
        tied.any(|known| pair.causes.iter().any(|c| c.identity() == known.cause.identity()))
    };
    let beside: f64 = pairs.iter().filter(is_one_of).map(|pair| pair.probability).sum();
    let double: f64 = pairs.iter().map(|pair| pair.probability).sum();
    if NAMED < probabilities.no_gap || causes.is_empty() {
        Verdict::NoGap
    } else if NAMED < probabilities.none_of_these {
        Verdict::NoneOfThese
    } else if NAMED < double {
        Verdict::Pair
    } else if NAMED < single + beside {
        if tied.len() == 1 { Verdict::Cause } else { Verdict::Tied }
    } else {
        Verdict::Unclear
    }
}
