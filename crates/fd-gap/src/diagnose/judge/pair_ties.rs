//! Which pairs are worth being called so, and which of them the log cannot tell apart.

use super::judged::NamedPairs;
use crate::{
    diagnose::{
        result::{Pair, PairId},
        settings::Settings,
        weigh::{
            answer::{Fit, PAIR},
            pair::FittedPair,
            rank::RankedCause,
        },
    },
    evidence::{SEPARATED, distance},
};

/// Rivals of the best pair that are refitted to its simulation.
const MOST_RIVALS: usize = 6;

/// A pair, and whether the log cannot tell it from the best one of two simulated causes.
struct Weighed {
    pair: Pair,
    is_tied: bool,
}

/// The pairs that are worth being called so, by their evidence over that of the best single cause.
/// `measured` is a cause of the measurement beside a simulated one.
pub(super) fn name_pairs(
    fitted: Vec<FittedPair>,
    measured: Option<Pair>,
    causes: &[RankedCause],
    settings: &Settings,
) -> NamedPairs {
    let single = causes.first().map_or(0.0, |ranked| ranked.cause.log_evidence.max(0.0));
    let is_worth_it = |pair: &Pair| single + PAIR < pair.log_evidence;
    let mut fitted: Vec<FittedPair> = fitted.into_iter().filter(|f| is_worth_it(&f.pair)).collect();
    let ties = are_tied(&mut fitted, settings);
    let each = fitted.iter().zip(ties);
    let mut all: Vec<Weighed> =
        each.map(|(f, is_tied)| Weighed { pair: f.pair.clone(), is_tied }).collect();
    all.extend(measured.filter(is_worth_it).map(|pair| Weighed { pair, is_tied: false }));
    all.sort_by(|a, b| b.pair.log_evidence.total_cmp(&a.pair.log_evidence));
    let tied = match all.first() {
        None => vec![],
        // One of the measurement ties with none.
        Some(Weighed { is_tied: false, .. }) => vec![PairId(0)],
        Some(_) => (0..all.len()).filter(|place| all[*place].is_tied).map(PairId).collect(),
    };
    NamedPairs { pairs: all.into_iter().map(|weighed| weighed.pair).collect(), tied, fitted }
}

/// Of each pair, whether this log cannot tell it from the first.
fn are_tied(fitted: &mut [FittedPair], settings: &Settings) -> Vec<bool> {
    let mut ties = vec![false; fitted.len()];
    let Some((first, others)) = fitted.split_first_mut() else { return ties };
    ties[0] = true;
    let Fit { problem: truth, minimum: at } = &mut first.fit;
    let near = others.iter().zip(&mut ties[1..]).take_while(|(other, _)| {
        first.pair.log_evidence - other.pair.log_evidence < settings.bayes_factor.ln()
    });
    for (FittedPair { fit: Fit { problem, minimum }, .. }, is_tied) in near.take(MOST_RIVALS) {
        *is_tied = distance(truth, at, problem, minimum) < SEPARATED;
    }
    ties
}
