//! From all candidates to fitted finalists.

mod command;
mod finalists;
mod screen;
pub(super) mod searched;
mod step_size;
pub(super) mod trial;

use rayon::prelude::*;

pub(super) use self::{command::Command, finalists::finish};
use self::{
    searched::Searched,
    step_size::with_short_steps,
    trial::{Trial, promises_less},
};
use super::{
    candidates::is_same_cause, context::Context, monitor::Stage, prepare::Prepared,
    result::NotTested,
};
use crate::{
    fit::{FitError, NullFit, Projection},
    quality::spectral_peaks,
};

/// Lines of the spectrum at which periodic effects are started.
const LINES: usize = 5;

/// More candidates than a library has for a plant of a few states: of so many …
const MANY: usize = 500;
/// … those are not fitted that promise less than this share of the best and are far below it. They would get one step of
/// a fit, and with a hundred places they are most of the work and of the memory.
const PROMISE_OF_MANY: f64 = 0.02;

/// Scores every candidate at every start by what it could explain besides the nuisances, fits it a
/// little from the best starts, and fits the best causes (effect and site, all their laws) to the
/// end, with an integration step that is short enough for them.
pub(super) fn search<'a>(
    prepared: Prepared,
    context: &Context<'a>,
) -> Result<Searched<'a>, FitError> {
    let Context { case, settings, monitor, .. } = *context;
    let (nominal, candidates) = (case.nominal, context.candidates.simulated.as_slice());
    let Prepared { model, null, noise } = prepared;
    let projection = Projection::new(&null.problem, &null.minimum).ok_or(FitError::Diverged)?;
    let lines = lines(&null)?;
    let commands = Command::all(nominal, &model, &null, candidates);
    monitor.begin(Stage::Screen, candidates.len());
    let tried: Vec<Result<Trial<'a>, NotTested>> = candidates
        .par_iter()
        .enumerate()
        .map(|(index, candidate)| {
            let refuse = |reason: String| NotTested::of(candidate, reason);
            // The first one is the best proposal, if they have an order.
            if 0 < index && monitor.is_stopped() {
                return Err(refuse(stopped()));
            }
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
    let of_many = if MANY < candidates.len() { PROMISE_OF_MANY } else { 0.0 };
    let least_promise = settings.least_promise.max(of_many);
    monitor.begin(Stage::Fit, trials.len());
    let fitted = case.suspects.fitted();
    let is_known = |trial: &Trial<'_>| fitted.is_some_and(|fitted| trial.is_in(fitted));
    let causes = promises(&trials);
    let is_faint = |trial: &Trial<'_>| {
        let promise = causes.iter().find(|(index, _)| *index == trial.index);
        promise.is_some_and(|(_, gain)| promises_less(*gain, least_promise, most))
    };
    let late: Vec<usize> = trials
        .par_iter_mut()
        .filter_map(|trial| {
            if 0 < trial.index && monitor.is_stopped() {
                return Some(trial.index);
            }
            if !is_known(trial) && is_faint(trial) {
                monitor.advance();
                return None;
            }
            trial.short_fits(&null, most);
            monitor.advance();
            None
        })
        .collect();
    trials.retain(|trial| {
        if trial.best.is_none() {
            let reason = if late.contains(&trial.index) {
                stopped()
            } else if is_faint(trial) {
                "others promise far more".to_owned()
            } else {
                "its simulation diverges".to_owned()
            };
            not_tested.push(NotTested::of(trial.candidate, reason));
        }
        trial.best.is_some()
    });
    if let Some(fitted) = fitted {
        trials.par_iter_mut().filter(|trial| is_known(trial)).for_each(|trial| {
            trial.start_as_in(&null, fitted);
        });
    }
    finish(&mut trials, &null, settings.finalists);
    if let Some(fitted) = fitted {
        // What stands for one of a longer list has as good a start as that one, which has had its own.
        let is_rival = |trial: &Trial<'_>| trial.is_final && !is_known(trial);
        trials.par_iter_mut().filter(|trial| is_rival(trial)).for_each(|trial| {
            if trial.start_as_in(&null, fitted) {
                trial.full_fit(&null);
            }
        });
    }
    let is_coloured = false;
    with_short_steps(
        nominal,
        Searched { model, null, noise, trials, not_tested, is_coloured, lines },
    )
}

/// The index of each candidate with what the best law of its cause could explain: laws are started from one another.
fn promises(trials: &[Trial<'_>]) -> Vec<(usize, f64)> {
    let of_cause = |trial: &Trial<'_>| {
        let laws = trials.iter().filter(|other| is_same_cause(other.candidate, trial.candidate));
        (trial.index, laws.map(Trial::gain).fold(0.0, f64::max))
    };
    trials.iter().map(of_cause).collect()
}

/// Why a candidate was not tried.
fn stopped() -> String {
    "the diagnosis was stopped before".to_owned()
}

/// Frequencies of the highest lines in the spectrum of what the null fit leaves, in Hz.
fn lines(null: &NullFit) -> Result<Vec<f64>, FitError> {
    let mut problem = null.problem.clone();
    let errors = problem.errors(&null.minimum.z).ok_or(FitError::Diverged)?;
    let signals: Vec<&[f64]> = errors.iter().flatten().map(Vec::as_slice).collect();
    let rate = 1.0 / problem.simulator().ts().seconds();
    Ok(spectral_peaks(&signals, LINES).into_iter().map(|f| f * rate).collect())
}
