//! From all candidates to fitted finalists.

use std::collections::HashSet;

use rayon::prelude::*;

use super::{
    monitor::{Monitor, Stage},
    result::NotTested,
    settings::Settings,
    trial::Trial,
};
use crate::{
    effect::{Candidate, Kind},
    evidence::likelihood,
    fit::{FitError, NullFit, Projection, Weights, null_fit},
    quality::spectral_peaks,
    simulate::Nominal,
};

/// Innovation, as a fraction of the noise, below which noise is coloured.
const COLOURED: f64 = 0.985;

/// Lines of the spectrum at which periodic effects are started.
const LINES: usize = 5;

/// All candidates, fitted as far as it was worth it.
pub(super) struct Found<'a> {
    pub(super) null: NullFit,
    pub(super) trials: Vec<Trial<'a>>,
    pub(super) not_tested: Vec<NotTested>,
    pub(super) is_coloured: bool,
}

pub(super) fn search<'a>(
    null: NullFit,
    nominal: &dyn Nominal,
    candidates: &'a [Candidate],
    spread: &[f64],
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Found<'a>, FitError> {
    let projection = Projection::new(&null.problem, &null.minimum).ok_or(FitError::Diverged)?;
    let lines = lines(&null)?;
    monitor.begin(Stage::Screen, candidates.len());
    let tried: Vec<Result<Trial<'a>, NotTested>> = candidates
        .par_iter()
        .enumerate()
        .map(|(index, candidate)| {
            let refuse = |reason: String| NotTested::of(candidate, reason);
            let tried = if candidate.kind == Kind::Simulation {
                Trial::new(nominal, candidate, index, &null).map_err(|e| refuse(e.to_string()))
            } else {
                Err(refuse("effects on the noise itself are not fitted yet".to_owned()))
            };
            let screened = tried.map(|mut trial| {
                trial.screen(&null, &projection, &lines);
                trial
            });
            monitor.advance();
            screened
        })
        .collect();
    let (mut trials, mut not_tested) = (Vec::new(), Vec::new());
    for outcome in tried {
        match outcome {
            Ok(trial) => trials.push(trial),
            Err(reason) => not_tested.push(reason),
        }
    }
    let most = trials.iter().map(Trial::gain).fold(0.0, f64::max);
    monitor.begin(Stage::Fit, trials.len());
    trials.par_iter_mut().for_each(|trial| {
        trial.short_fits(&null, most);
        monitor.advance();
    });
    trials.retain(|trial| {
        if trial.best.is_none() {
            let reason = "its simulation diverges".to_owned();
            not_tested.push(NotTested::of(trial.candidate, reason));
        }
        trial.best.is_some()
    });
    finish(&mut trials, &null, settings.finalists);

    let mut found = Found { null, trials, not_tested, is_coloured: false };
    if let Some(weights) = colours(&mut found, spread) {
        let Found { null, trials, .. } = &found;
        let recoloured = null_fit(null.problem.plan(), null.problem.simulator(), &weights)?;
        debug_assert!(trials.len() <= candidates.len(), "one trial per candidate");
        found.null = recoloured;
        found.is_coloured = true;
        let null = &found.null;
        found.trials.par_iter_mut().for_each(|trial| trial.recolour(null, &weights));
        finish(&mut found.trials, null, settings.finalists);
    }
    Ok(found)
}

/// Frequencies of the highest lines in the spectrum of what the null fit leaves, in Hz.
fn lines(null: &NullFit) -> Result<Vec<f64>, FitError> {
    let mut problem = null.problem.clone();
    let errors = problem.errors(&null.minimum.z).ok_or(FitError::Diverged)?;
    let signals: Vec<&[f64]> = errors.iter().flatten().map(Vec::as_slice).collect();
    let rate = 1.0 / problem.simulator().ts().seconds();
    Ok(spectral_peaks(&signals, LINES).into_iter().map(|f| f * rate).collect())
}

/// Fits the laws of the best causes to the end.
fn finish(trials: &mut [Trial<'_>], null: &NullFit, finalists: usize) {
    let mut order: Vec<usize> = (0..trials.len()).collect();
    order.sort_by(|a, b| trials[*a].cost().total_cmp(&trials[*b].cost()));
    let key = |trial: &Trial<'_>| {
        let candidate = trial.candidate;
        (candidate.label, candidate.site.clone(), candidate.partner.clone())
    };
    let mut chosen = HashSet::new();
    for i in order {
        if chosen.len() < finalists {
            chosen.insert(key(&trials[i]));
        }
    }
    trials
        .par_iter_mut()
        .filter(|trial| chosen.contains(&key(trial)))
        .for_each(|trial| trial.full_fit(null));
    // A law starts from the best one of its cause as well, by the names of the parameters.
    let mut starts: Vec<Option<Vec<f64>>> = Vec::with_capacity(trials.len());
    for trial in trials.iter() {
        let peers = trials.iter().filter(|peer| key(peer) == key(trial));
        let best = peers.min_by(|a, b| a.cost().total_cmp(&b.cost()));
        let is_chosen = chosen.contains(&key(trial));
        let other = best.filter(|best| is_chosen && best.index != trial.index);
        starts.push(other.and_then(|best| best.values_for(trial.candidate)));
    }
    trials.par_iter_mut().zip(starts).for_each(|(trial, start)| {
        if let Some(values) = start
            && trial.warm_start(null, &values)
        {
            trial.full_fit(null);
        }
    });
}

/// The colour of what the best fit leaves, if it has one.
fn colours(found: &mut Found<'_>, spread: &[f64]) -> Option<Weights> {
    let mut weights = found.null.problem.weights().clone();
    let best = found.trials.iter_mut().min_by(|a, b| a.cost().total_cmp(&b.cost()));
    let errors = match best {
        Some(trial) => {
            let best = trial.best.as_ref()?;
            trial.problem.errors(&best.z)
        }
        None => found.null.problem.errors(&found.null.minimum.z),
    };
    weights.colour = likelihood(&errors?, spread, true).colour;
    weights.colour.iter().any(|colour| colour.innovation() < COLOURED).then_some(weights)
}
