//! From evidence to probabilities.

use crate::{
    diagnose::{
        result::{Leftover, Pair},
        settings::Settings,
        weigh::{answer::Answer, lack_of_fit::LackOfFit, priors::Priors, rank::RankedCause},
    },
    evidence::{
        grades::{BEYOND_DOUBT, STRONG, VERY_STRONG},
        probabilities,
    },
};

/// Share of the amplitude of the gap from which what is left may be the work of something else;
/// less is the right mechanism with another law.
const OTHER: f64 = 0.15;

/// Probabilities of the answers that are neither a cause nor a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) struct Probabilities {
    pub no_gap: f64,
    pub none_of_these: f64,
}

/// Answers that exclude each other, with their probabilities.
#[derive(Debug)]
pub(super) struct Believed {
    pub others: Probabilities,
    pub causes: Vec<RankedCause>,
    pub pairs: Vec<Pair>,
}

/// Log-likelihood that something unknown could gain over an explanation that leaves `left`.
pub(super) fn unknown_gain(left: &Leftover) -> f64 {
    if OTHER < left.share { left.gain() } else { 0.0 }
}

/// Where something is missing beyond doubt, if only in the law, the answer is another one with at least this probability.
/// Of laws that the library has in another form the first label was right in .73 of blind cases (docs/results/blind.md, seed
/// 20270715).
const ANOTHER: f64 = 0.25;
/// Where nothing but noise is left, "none of these" can be no verdict.
const NOT_MORE: f64 = 0.5;

/// Bounds of the probability of "none of these" by what the best explanation leaves.
///
/// Wrong samples that come in bursts leave nothing when they are left out: then it is their `doubt` that counts.
/// A free curve (`is_curve`) is no law: what it follows may as well be one that nobody has listed.
pub(super) fn bounded(
    believed: Believed,
    left: &LackOfFit,
    doubt: f64,
    is_curve: bool,
) -> Believed {
    let Believed { others: Probabilities { no_gap, none_of_these }, mut causes, mut pairs } =
        believed;
    let gain = left.leftover.gain();
    let low = if BEYOND_DOUBT < gain || is_curve { ANOTHER * (1.0 - no_gap) } else { 0.0 };
    let is_noise = !left.is_unexplained && gain + doubt < STRONG;
    let high = if is_noise { NOT_MORE * (1.0 - no_gap) } else { 1.0 };
    // What is named, as it is: of 1 less all others only rounding may be left.
    let of_causes = causes.iter().map(|ranked| ranked.cause.probability);
    let named: f64 = of_causes.chain(pairs.iter().map(|pair| pair.probability)).sum();
    if named <= 0.0 {
        // With nothing to name, nothing can be taken from doubt.
        return Believed { others: Probabilities { no_gap, none_of_these }, causes, pairs };
    }
    let none_of_these = none_of_these.max(low).min(high);
    let factor = (1.0 - no_gap - none_of_these).max(0.0) / named;
    for ranked in &mut causes {
        ranked.cause.probability *= factor;
    }
    for pair in &mut pairs {
        pair.probability *= factor;
    }
    Believed { others: Probabilities { no_gap, none_of_these }, causes, pairs }
}

/// Gives causes, pairs and the other answers their probabilities. Something unknown, alone or beside
/// the `best` explanation, could gain `gain`.
pub(super) fn believe(
    mut causes: Vec<RankedCause>,
    mut pairs: Vec<Pair>,
    best: &Answer,
    gain: f64,
    settings: &Settings,
) -> Believed {
    let Settings { unknown, temperature, .. } = *settings;
    let n = causes.len();
    let priors = Priors::of(settings, n);
    let known = [priors.no_gap, priors.cause, priors.pair][best.effects.min(2)];
    let prior = known * unknown / (1.0 - unknown);
    // An unknown cause has a strength as well, which the data know.
    let mut answers = vec![(0.0, priors.no_gap), (best.log_evidence + gain - VERY_STRONG, prior)];
    answers.extend(causes.iter().map(|ranked| (ranked.cause.log_evidence, priors.cause)));
    answers.extend(pairs.iter().map(|pair| (pair.log_evidence, priors.pair)));
    let found = probabilities(&answers, temperature);
    let (of_causes, of_pairs) = found[2..].split_at(n);
    causes.iter_mut().zip(of_causes).for_each(|(ranked, p)| ranked.cause.probability = *p);
    pairs.iter_mut().zip(of_pairs).for_each(|(pair, p)| pair.probability = *p);
    let others = Probabilities { no_gap: found[0], none_of_these: found[1] };
    Believed { others, causes, pairs }
}
