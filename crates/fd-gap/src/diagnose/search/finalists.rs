//! The fits to the end.

use crate::together::each;
use fd_effect::Candidate;

use super::trial::Trial;
use crate::{diagnose::candidates::is_same_cause, fit::NullFit};

/// Fits the laws of the best causes to the end.
pub(in crate::diagnose) fn finish(trials: &mut [Trial<'_>], null: &NullFit, finalists: usize) {
    let mut by_cost: Vec<&Trial<'_>> = trials.iter().collect();
    by_cost.sort_by(|a, b| a.cost().total_cmp(&b.cost()));
    let best = by_cost.first().map_or(f64::INFINITY, |trial| trial.cost());
    let mut chosen: Vec<&Candidate> = Vec::new();
    for trial in by_cost {
        let is_worth_it = !trial.is_not_worth_a_run(best);
        if chosen.len() < finalists && is_worth_it && !is_among(&chosen, trial) {
            chosen.push(trial.candidate);
        }
    }
    // Of a cause that is worth it, all laws are: where slopes are rough, what they promise says little of the right one.
    let fitted = trials.iter_mut().filter(|trial| is_among(&chosen, trial));
    each(fitted, |trial| trial.full_fit(null));
    // A law starts from the best one of its cause as well, by the names of the parameters.
    let mut starts: Vec<Option<Vec<f64>>> = Vec::with_capacity(trials.len());
    for trial in trials.iter() {
        let peers = trials.iter().filter(|peer| is_same_cause(peer.candidate, trial.candidate));
        let best = peers.min_by(|a, b| a.cost().total_cmp(&b.cost()));
        let is_chosen = is_among(&chosen, trial);
        let other = best.filter(|best| is_chosen && best.index != trial.index);
        starts.push(other.and_then(|best| best.values_for(trial.candidate)));
    }
    each(trials.iter_mut().zip(starts), |(trial, start)| {
        if let Some(values) = start
            && trial.warm_start(null, &values)
        {
            trial.full_fit(null);
        }
    });
}

/// A few iterations from where the same laws ended that are `known` to the end, with another horizon or other starts of the
/// logs: what an effect is may not be found from what is missing in a window, but once it is known, it fits.
pub(super) fn go_on(trials: &mut [Trial<'_>], null: &NullFit, known: &[Trial<'_>]) {
    let shared = null.problem.plan().nuisances().len();
    each(trials.iter_mut(), |trial| {
        let before = known.iter().find(|known| known.is_final && known.index == trial.index);
        let Some(Trial { problem, best: Some(best), .. }) = before else { return };
        let mut nuisances = null.minimum.z.clone();
        nuisances[..shared].copy_from_slice(&best.z[..shared]);
        trial.warm_start_at(&nuisances, &problem.effect_values(&best.z));
    });
}

/// Whether a trial is of one of the chosen causes.
fn is_among(chosen: &[&Candidate], trial: &Trial<'_>) -> bool {
    chosen.iter().any(|candidate| is_same_cause(candidate, trial.candidate))
}
