//! From all candidates to fitted finalists.

mod command;
mod finalists;
mod from_nominal;
mod screen;
mod screened;
pub(super) mod searched;
pub(super) mod step_size;
pub(super) mod trial;

use std::collections::HashMap;

use crate::together::each;

pub(super) use self::{command::Command, finalists::finish};
use self::{
    from_nominal::nominal_where_bent,
    screened::Screened,
    searched::Searched,
    step_size::with_short_steps,
    trial::{MORE_THAN_PROMISED, Trial, is_hopeless},
};
use super::{context::Context, monitor::Stage, prepare::Prepared, result::NotTested};
use crate::{
    fit::{FitError, NullFit, Projection},
    quality::spectral_peaks,
};

/// Lines of the spectrum at which periodic effects are started.
const LINES: usize = 5;

/// More candidates than a library has for a plant of a few states: of so many those that are hopeless are not fitted. They would
/// get one step of a fit, and with a hundred places they are most of the work and of the memory.
const MANY: usize = 500;

/// Scores every candidate at every start by what it could explain besides the nuisances, fits it a
/// little from the best starts, and fits the best causes (effect and site, all their laws) to the
/// end, with an integration step that is short enough for them.
pub(super) fn search<'a>(
    prepared: Prepared,
    context: &Context<'a>,
) -> Result<Searched<'a>, FitError> {
    with_short_steps(context.case.nominal, search_beside(prepared, 0.0, context)?)
}

/// The same with the integration step that the model has, beside whatever has been found already: causes that promise by far less
/// than the `least` that they must take from the sum of squares are not fitted.
pub(super) fn search_beside<'a>(
    prepared: Prepared,
    least: f64,
    context: &Context<'a>,
) -> Result<Searched<'a>, FitError> {
    let Context { case, settings, monitor, .. } = *context;
    let (nominal, candidates) = (case.nominal, context.candidates.simulated.as_slice());
    let Prepared { model, null, noise } = prepared;
    let projection = Projection::new(&null.problem, &null.minimum).ok_or(FitError::Diverged)?;
    let lines = lines(&null)?;
    let commands = Command::all(nominal, &model, &null, candidates);
    monitor.begin(Stage::Screen, candidates.len());
    let is_many = MANY < candidates.len();
    let tried = each(candidates.iter().enumerate(), |(index, candidate)| {
        let refuse = |reason: String| NotTested::of(candidate, reason);
        // The first one is the best proposal, if they have an order.
        if 0 < index && monitor.is_stopped() {
            return Err(refuse(stopped()));
        }
        let tried = Trial::new(nominal, candidate, index, &null).map_err(|e| refuse(e.to_string()));
        let screened = tried.map(|mut trial| {
            let command = Command::of_candidate(&commands, candidate);
            trial.screen(&null, &projection, &lines, command);
            Screened::of(trial, is_many)
        });
        monitor.advance();
        screened
    });
    let mut not_tested = Vec::new();
    let screened = tested(tried, &mut not_tested);
    let most = screened.iter().map(Screened::gain).fold(0.0, f64::max);
    let unbent = nominal_where_bent(&null);
    monitor.begin(Stage::Fit, screened.len());
    let (promises, shortlisted) = promises(&screened, settings.shortlist);
    let fits = each(screened.into_iter().zip(promises), |(screened, promise)| {
        let Screened { candidate, index, .. } = screened;
        let refuse = |reason: String| NotTested::of(candidate, reason);
        if 0 < index && monitor.is_stopped() {
            return Err(refuse(stopped()));
        }
        let is_short_of_it = promise < (least / MORE_THAN_PROMISED).max(shortlisted);
        if is_short_of_it || is_many && is_hopeless(promise, most) {
            monitor.advance();
            return Err(refuse("others promise far more".to_owned()));
        }
        let again = |candidate| Trial::new(nominal, candidate, index, &null);
        let mut trial = screened.trial(again).map_err(|e| refuse(e.to_string()))?;
        trial.short_fits(&null, unbent.as_deref(), most);
        monitor.advance();
        let diverges = || refuse("its simulation diverges".to_owned());
        if trial.best.is_some() { Ok(trial) } else { Err(diverges()) }
    });
    let mut trials = tested(fits, &mut not_tested);
    finish(&mut trials, &null, settings.finalists);
    let is_coloured = false;
    Ok(Searched { model, null, noise, trials, not_tested, is_coloured })
}

/// What was tested; why the rest was not goes to the others of that kind.
fn tested<T>(outcomes: Vec<Result<T, NotTested>>, not_tested: &mut Vec<NotTested>) -> Vec<T> {
    let keep = |outcome: Result<T, _>| outcome.map_err(|reason| not_tested.push(reason)).ok();
    outcomes.into_iter().filter_map(keep).collect()
}

/// What the best law of the cause of each candidate could explain, since laws are started from one another; and the least
/// on a shortlist of so many causes.
fn promises(screened: &[Screened<'_>], length: usize) -> (Vec<f64>, f64) {
    let mut best = HashMap::new();
    for one in screened {
        let gain = best.entry(one.candidate.identity()).or_insert(0.0_f64);
        *gain = gain.max(one.gain());
    }
    let promises = screened.iter().map(|one| best[&one.candidate.identity()]).collect();
    let mut all: Vec<f64> = best.into_values().collect();
    all.sort_by(|a, b| b.total_cmp(a));
    (promises, all.get(length.saturating_sub(1)).copied().unwrap_or(0.0))
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
