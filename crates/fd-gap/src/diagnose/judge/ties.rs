//! Ties: causes that the log cannot tell from the first one.

use super::judged::Ties;
use crate::{
    diagnose::{
        result::{CauseId, RivalCause},
        search::searched::Searched,
        settings::Settings,
        weigh::rank::{Basis, RankedCause},
    },
    evidence::{SEPARATED, distance},
};

/// The causes that this log cannot tell from the first, and those that are nearly as probable but
/// could be told apart. A cause of the measurement ties with none: it has no simulation of its own.
pub(super) fn ties(causes: &[RankedCause], searched: &Searched<'_>, settings: &Settings) -> Ties {
    let Some(first) = causes.first() else { return Ties::default() };
    let mut ties = Ties { tied: vec![CauseId(0)], rivals: Vec::new() };
    let fitted = |ranked: &RankedCause| match ranked.basis {
        Basis::Simulation(id) => {
            let trial = searched.trial(id);
            trial.best.as_ref().map(|best| (&trial.problem, best))
        }
        Basis::Measurement(_) => None,
    };
    let Some((truth, at)) = fitted(first) else { return ties };
    let near = causes.iter().enumerate().skip(1).take_while(|(_, ranked)| {
        first.cause.log_evidence - ranked.cause.log_evidence < settings.bayes_factor.ln()
    });
    for (place, ranked) in near {
        let Some((problem, rival_at)) = fitted(ranked) else { continue };
        let cause = CauseId(place);
        let distance = distance(truth, at, problem, rival_at);
        if distance < SEPARATED {
            ties.tied.push(cause);
        } else {
            ties.rivals.push(RivalCause { cause, distance });
        }
    }
    ties
}
