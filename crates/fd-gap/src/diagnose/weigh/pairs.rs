//! Second causes beside first ones.

use std::sync::Arc;

use fd_effect::{Candidate, Kind};
use rayon::prelude::*;

use super::{
    pair::FittedPair,
    rank::{Basis, RankedCause},
    singles::Singles,
};
use crate::{
    diagnose::{
        candidates::{is_free_curve, is_same_cause},
        case::Case,
        context::Context,
        monitor::Stage,
        prepare::step::with_step,
        search::{
            Command,
            searched::Searched,
            trial::{MORE_THAN_PROMISED, Trial},
        },
    },
    fit::{FitError, NullFit, Plan, Problem, Projection},
};

/// First causes that others are tried beside.
const FIRSTS: usize = 4;
/// Best single causes of which all pairs are tried.
const SINGLES: usize = 6;
/// Other second causes that get a short fit, by what they could explain.
const HOPEFUL: usize = 6;
/// Second causes of each first one that are fitted to the end.
const FINALISTS: usize = 3;

/// Pairs of simulated causes, the best first; none where the settings have no room for them.
pub(super) fn seek_pairs(singles: &Singles<'_>, context: &Context<'_>) -> Vec<FittedPair> {
    let monitor = context.monitor;
    if context.settings.two <= 0.0 {
        return Vec::new();
    }
    let trial = |ranked: &RankedCause| match ranked.basis {
        Basis::Simulation(id) => Some(singles.searched.trial(id)),
        Basis::Measurement(_) => None,
    };
    let best: Vec<&Trial<'_>> = singles
        .causes
        .iter()
        .filter_map(trial)
        .filter(|trial| !is_free_curve(trial.candidate) && trial.best.is_some())
        .take(SINGLES)
        .collect();
    let firsts = &best[..FIRSTS.min(best.len())];
    monitor.begin(Stage::Pairs, firsts.len());
    let found: Vec<Vec<FittedPair>> = firsts
        .par_iter()
        .map(|first| {
            if monitor.is_stopped() {
                return Vec::new();
            }
            let pairs = beside(first, &best, singles, context).unwrap_or_default();
            monitor.advance();
            pairs
        })
        .collect();
    let mut all: Vec<FittedPair> = found.into_iter().flatten().collect();
    all.sort_by(|a, b| b.pair.log_evidence.total_cmp(&a.pair.log_evidence));
    let mut kept: Vec<FittedPair> = Vec::new();
    for pair in all {
        if !kept.iter().any(|known| known.is_of(&pair)) {
            kept.push(pair);
        }
    }
    kept
}

/// The best second causes beside a first one, as far as the two may come near the noise: far above it, pairs are no answer.
/// Those that are among the `best` alone are fitted even if others could explain more.
fn beside(
    first: &Trial<'_>,
    best: &[&Trial<'_>],
    singles: &Singles<'_>,
    context: &Context<'_>,
) -> Result<Vec<FittedPair>, FitError> {
    let Searched { null, lines, noise, .. } = &singles.searched;
    let Case { nominal, suspects, .. } = context.case;
    // The first cause is one more nuisance.
    let plan: Plan = null.problem.plan().with_parameters(first.problem.effects());
    let (simulator, weights) = (first.problem.simulator(), first.problem.weights());
    let mut problem = Problem::new(Arc::new(plan), simulator.boxed(), vec![], weights.clone())?;
    let minimum = first.best.as_ref().and_then(|best| best.with_slopes(&mut problem));
    let Some(minimum) = minimum else { return Ok(Vec::new()) };
    let base = NullFit { minimum: minimum.shared(&problem), problem };
    let errors = base.problem.clone().errors(&base.minimum.z).ok_or(FitError::Diverged)?;
    let least = to_take(base.minimum.cost, noise.farness(&errors)) / MORE_THAN_PROMISED;
    let projection = Projection::new(&base.problem, &base.minimum).ok_or(FitError::Diverged)?;
    let candidates: Vec<Candidate> = suspects
        .beside(first.candidate)
        .into_iter()
        .flatten()
        .filter(|second| second.kind == Kind::Simulation && !is_free_curve(second))
        .filter(|second| !is_same_cause(second, first.candidate))
        .map(|second| match first.model.step {
            Some(step) => Candidate { model: with_step(&second.model, step), ..second },
            None => second,
        })
        .collect();
    let commands = Command::all(nominal, &first.model, &base, &candidates);
    let mut trials: Vec<Trial<'_>> = Vec::with_capacity(candidates.len());
    for (index, candidate) in candidates.iter().enumerate() {
        if let Ok(mut trial) = Trial::new(nominal, candidate, index, &base) {
            trial.screen(&base, &projection, lines, Command::of_candidate(&commands, candidate));
            trials.push(trial);
        }
    }
    trials.sort_by(|a, b| b.gain().total_cmp(&a.gain()).then(a.index.cmp(&b.index)));
    let most = trials.first().map_or(0.0, Trial::gain);
    let is_single = |trial: &Trial<'_>| {
        best.iter().any(|single| {
            is_same_cause(single.candidate, trial.candidate)
                && single.candidate.law == trial.candidate.law
        })
    };
    let mut place = 0;
    trials.retain(|trial| {
        place += 1;
        least <= trial.gain() && (place <= HOPEFUL || is_single(trial))
    });
    for trial in &mut trials {
        trial.short_fits(&base, most);
    }
    trials.sort_by(|a, b| a.cost().total_cmp(&b.cost()).then(a.index.cmp(&b.index)));
    trials.truncate(FINALISTS);
    let pairs = trials.into_iter().filter_map(|mut second| {
        second.full_fit(&base);
        FittedPair::of(first, &second, null, &singles.reference)
    });
    Ok(pairs.collect())
}

/// What a second cause has to take of the squares that a first one leaves, where these are so many times as far from the
/// noise as likelihoods are of use.
fn to_take(squares: f64, farness: f64) -> f64 {
    squares * (1.0 - farness.max(1.0).powi(-2))
}

#[cfg(test)]
mod tests {
    use super::to_take;

    #[test]
    #[expect(clippy::float_cmp, reason = "powers of two are exact")]
    fn a_second_cause_takes_what_is_far_from_the_noise() {
        assert_eq!(to_take(64.0, 0.5), 0.0);
        assert_eq!(to_take(64.0, 1.0), 0.0);
        assert_eq!(to_take(64.0, 4.0), 60.0);
    }
}
