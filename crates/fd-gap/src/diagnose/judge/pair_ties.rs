//! Which pairs are worth being called so, and which of them the log cannot tell apart.

use super::judged::NamedPairs;
use crate::{
    diagnose::{
        result::{Pair, PairId},
        sets::EffectSet,
        settings::Settings,
        weigh::{
            answer::{Fit, is_a_pair},
            rank::RankedCause,
        },
    },
    evidence::{SEPARATED, distance},
};

/// A pair, and what it is tied with.
struct Weighed {
    pair: Pair,
    tie: Tie,
}

/// What the log cannot tell a pair from.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Tie {
    /// From the best pair of two simulated causes, itself included.
    Simulated,
    /// From the other pairs with the same cause of the measurement.
    Measured,
    /// From nothing that was looked at.
    Alone,
}

/// The pairs that are worth being called so, by their evidence over that of the best single cause.
/// `measured` is a cause of the measurement beside a simulated one, and beside those that tie with it. Where it is in the best
/// answer beside two simulated ones, it gains `third` there.
pub(super) fn name_pairs(
    fitted: Vec<EffectSet>,
    third: f64,
    measured: Vec<Pair>,
    causes: &[RankedCause],
    settings: &Settings,
) -> NamedPairs {
    let single = causes.first().map_or(0.0, |ranked| ranked.cause.log_evidence.max(0.0));
    let is_worth_it = |evidence: f64| is_a_pair(evidence, single);
    let mut fitted = fitted;
    fitted.retain(|set| is_worth_it(set.log_evidence));
    let ties = are_tied(&mut fitted, settings);
    let each = fitted.iter().zip(ties);
    let each = each.filter_map(|(set, tie)| {
        let pair = set.pair()?;
        let log_evidence = pair.log_evidence + third;
        Some(Weighed { pair: Pair { log_evidence, ..pair }, tie })
    });
    let mut all: Vec<Weighed> = each.collect();
    let measured = measured.into_iter().filter(|pair| is_worth_it(pair.log_evidence));
    all.extend(measured.map(|pair| Weighed { pair, tie: Tie::Measured }));
    all.sort_by(|a, b| b.pair.log_evidence.total_cmp(&a.pair.log_evidence));
    let tied = match all.first().map(|first| first.tie) {
        None => vec![],
        Some(Tie::Alone) => vec![PairId(0)],
        Some(tie) => (0..all.len()).filter(|place| all[*place].tie == tie).map(PairId).collect(),
    };
    NamedPairs { pairs: all.into_iter().map(|weighed| weighed.pair).collect(), tied, fitted }
}

/// Of each pair, whether this log cannot tell it from the first.
fn are_tied(fitted: &mut [EffectSet], settings: &Settings) -> Vec<Tie> {
    let mut ties = vec![Tie::Alone; fitted.len()];
    let Some((first, others)) = fitted.split_first_mut() else { return ties };
    ties[0] = Tie::Simulated;
    let Fit { problem: truth, minimum: at } = &mut first.fit;
    let near = others.iter().zip(&mut ties[1..]).take_while(|(other, _)| {
        first.log_evidence - other.log_evidence < settings.bayes_factor.ln()
    });
    for (EffectSet { fit: Fit { problem, minimum }, .. }, tie) in near {
        if distance(truth, at, problem, minimum) < SEPARATED {
            *tie = Tie::Simulated;
        }
    }
    ties
}
