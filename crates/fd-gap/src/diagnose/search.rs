//! From all candidates to fitted finalists.

use std::collections::HashSet;

use fd_effect::Candidate;
use fd_sim::{model::Model, simulate::Nominal};
use rayon::prelude::*;

use super::{
    command::Command,
    leftover::COLOURED,
    monitor::{Monitor, Stage},
    prepare::KnownNoise,
    result::NotTested,
    settings::Settings,
    trial::Trial,
};
use crate::{
    evidence::likelihood,
    fit::{FitError, NullFit, Projection, Weights, null_fit},
    quality::spectral_peaks,
};

/// Lines of the spectrum at which periodic effects are started.
const LINES: usize = 5;

/// All candidates, fitted as far as it was worth it.
#[derive(Debug)]
pub(super) struct Found<'a> {
    pub(super) null: NullFit,
    pub(super) trials: Vec<Trial<'a>>,
    pub(super) not_tested: Vec<NotTested>,
    pub(super) is_coloured: bool,
    /// Frequencies of the highest lines in the spectrum of what the null fit left, in Hz.
    pub(super) lines: Vec<f64>,
}

pub(super) fn search<'a>(
    null: NullFit,
    (nominal, model): (&dyn Nominal, &Model),
    candidates: &'a [Candidate],
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Found<'a>, FitError> {
    let projection = Projection::new(&null.problem, &null.minimum).ok_or(FitError::Diverged)?;
    let lines = lines(&null)?;
    let commands = Command::all(nominal, model, &null, candidates);
    monitor.begin(Stage::Screen, candidates.len());
    let tried: Vec<Result<Trial<'a>, NotTested>> = candidates
        .par_iter()
        .enumerate()
        .map(|(index, candidate)| {
            let refuse = |reason: String| NotTested::of(candidate, reason);
            let tried =
                Trial::new(nominal, candidate, index, &null).map_err(|e| refuse(e.to_string()));
            let screened = tried.map(|mut trial| {
                let command = Command::of_candidate(&commands, candidate);
                trial.screen(&null, &projection, &lines, command);
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

    Ok(Found { null, trials, not_tested, is_coloured: false, lines })
}

impl Found<'_> {
    /// What the best single fit leaves, in sigma.
    pub(super) fn best_errors(&self) -> Option<Vec<Vec<Vec<f64>>>> {
        let best = self.trials.iter().min_by(|a, b| a.cost().total_cmp(&b.cost()));
        match best.and_then(|trial| Some((trial, trial.best.as_ref()?))) {
            Some((trial, best)) => trial.problem.clone().errors(&best.z),
            None => self.null.problem.clone().errors(&self.null.minimum.z),
        }
    }

    /// Gives the noise the colour of what the best explanation leaves, and fits everything again
    /// with it. Says whether there is one.
    pub(super) fn colour(
        &mut self,
        left: &[Vec<Vec<f64>>],
        noise: &KnownNoise,
        finalists: usize,
    ) -> Result<bool, FitError> {
        let mut weights: Weights = self.null.problem.weights().clone();
        weights.colour = likelihood(left, &noise.priors(true)).colour;
        self.is_coloured = weights.colour.iter().any(|colour| colour.innovation() < COLOURED);
        if self.is_coloured {
            self.null =
                null_fit(self.null.problem.plan(), self.null.problem.simulator(), &weights)?;
            let null = &self.null;
            let least = self.trials.iter().map(Trial::cost).fold(f64::INFINITY, f64::min);
            self.trials.par_iter_mut().for_each(|trial| trial.recolour(null, &weights, least));
            finish(&mut self.trials, null, finalists);
        }
        Ok(self.is_coloured)
    }
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
