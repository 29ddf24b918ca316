//! The answer in one word.

use super::{
    judged::{NamedPairs, Ties},
    probabilities::Probabilities,
};
use crate::diagnose::{result::Verdict, weigh::rank::RankedCause};

/// Probability from which an answer is named.
pub(crate) const NAMED: f64 = 0.5;

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
    // The first one, alone or beside another: sums over what is tied would name a crowd of faint ones.
    let first = causes.first().map_or(0.0, |first| first.cause.at_work(pairs));
    let double: f64 = pairs.iter().map(|pair| pair.probability).sum();
    if NAMED < probabilities.no_gap || causes.is_empty() {
        Verdict::NoGap
    } else if NAMED < probabilities.none_of_these {
        Verdict::NoneOfThese
    } else if NAMED < double {
        Verdict::Pair
    } else if NAMED < single.max(first) {
        if tied.len() == 1 { Verdict::Cause } else { Verdict::Tied }
    } else {
        Verdict::Unclear
    }
}
