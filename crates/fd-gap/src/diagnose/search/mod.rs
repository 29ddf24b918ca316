//! From all candidates to fitted finalists.

mod base;
mod change;
pub(super) mod changes;
mod command;
mod finalists;
mod screen;
mod screened;
pub(super) mod searched;
pub(super) mod step_size;
pub(super) mod trial;

use std::sync::{Arc, OnceLock};

use fd_effect::Candidate;
use fd_sim::model::Model;

use crate::together::each;

use self::{
    base::{base, is_of_the_fit},
    changes::Changes,
    finalists::go_on,
    screened::{Screened, of_causes},
    searched::Searched,
    step_size::with_short_steps,
    trial::{MORE_THAN_PROMISED, Trial, is_hopeless},
};
pub(super) use self::{command::Command, finalists::finish};
use super::{context::Context, monitor::Stage, prepare::Prepared, result::NotTested};
use crate::{
    fit::{FitError, NullFit, Surroundings},
    quality::spectral_peaks,
};

/// Lines of the spectrum at which periodic effects are started.
const LINES: usize = 5;

/// Scores every candidate at every start by what it could explain besides the nuisances, fits those that promise something
/// a little from the best starts, and fits the best causes (effect and site, all their laws) to the end, with an integration
/// step that is short enough for them; also from where laws ended that are `known` from another horizon or other starts of the logs.
pub(super) fn search<'a>(
    prepared: Prepared,
    known: &[Trial<'a>],
    context: &Context<'a>,
) -> Result<Searched<'a>, FitError> {
    let mut searched = looked(prepared, 0.0, Arc::default(), context)?;
    go_on(&mut searched.trials, &searched.null, known);
    finish(&mut searched.trials, &searched.null, context.settings.finalists);
    with_short_steps(context.case.nominal, searched)
}

/// A search that goes on from where laws ended that are `known` from another horizon, whether or not it had fitted them.
pub(super) fn carried_on<'a>(
    searched: Searched<'a>,
    known: &[Trial<'a>],
    context: &Context<'a>,
) -> Result<Searched<'a>, FitError> {
    let Searched { null, mut trials, mut not_tested, mut screening, .. } = searched;
    screening += known.iter().map(|known| known.problem.simulations()).sum::<usize>();
    let is_new = |known: &&Trial<'_>| {
        known.is_final && trials.iter().all(|trial| trial.index != known.index)
    };
    let new = known.iter().filter(is_new).map(|known| {
        let trial = Trial::new(context.case.nominal, known.candidate, known.index, &null);
        trial.map_err(|e| refused(known.candidate, &e.to_string()))
    });
    let new = tested(new.collect(), &mut not_tested);
    trials.extend(new);
    trials.sort_by_key(|trial| trial.index);
    go_on(&mut trials, &null, known);
    trials.retain(|trial| trial.best.is_some());
    let is_of = |refused: &NotTested, Candidate { label, law, site, .. }: &Candidate| {
        (refused.label, refused.law, &refused.site) == (*label, *law, site)
    };
    not_tested.retain(|refused| trials.iter().all(|trial| !is_of(refused, trial.candidate)));
    finish(&mut trials, &null, context.settings.finalists);
    let searched = Searched { null, screening, trials, not_tested, ..searched };
    with_short_steps(context.case.nominal, searched)
}

/// The same with the integration step that the model has, beside whatever has been found already: causes that promise by far less
/// than the `least` that they must take from the sum of squares are not fitted, and of those of which the changes are
/// remembered only the most promising are looked at; where none are, those of this look will be.
pub(super) fn search_beside<'a>(
    prepared: Prepared,
    least: f64,
    changes: Arc<OnceLock<Changes>>,
    context: &Context<'a>,
) -> Result<Searched<'a>, FitError> {
    let mut searched = looked(prepared, least, changes, context)?;
    finish(&mut searched.trials, &searched.null, context.settings.finalists);
    Ok(searched)
}

/// The scores and the short fits.
fn looked<'a>(
    prepared: Prepared,
    least: f64,
    changes: Arc<OnceLock<Changes>>,
    context: &Context<'a>,
) -> Result<Searched<'a>, FitError> {
    let Prepared { model, null, noise } = prepared;
    let base = base(&null);
    let around = &Surroundings::new(&null.problem, &base).ok_or(FitError::Diverged)?;
    let candidates = context.candidates.simulated.as_slice();
    let remembered = changes.get();
    let promising = remembered.map(|known| known.promising(candidates, &null, around));
    let look = Look { context, null: &null, around };
    let mut not_tested = Vec::new();
    let mut screened = tested(look.screened(&model, promising.as_deref())?, &mut not_tested);
    if remembered.is_none()
        && let Some(seen) = Changes::of(&null, &mut screened)
    {
        changes.get_or_init(|| seen);
    }
    let screening = screened.iter().map(|one| one.simulations).sum();
    let trials = look.fitted(screened, least, &mut not_tested);
    let is_coloured = false;
    Ok(Searched { model, null, noise, screening, changes, trials, not_tested, is_coloured })
}

/// One look at all candidates.
struct Look<'s, 'a> {
    context: &'s Context<'a>,
    /// Without any of them.
    null: &'s NullFit,
    /// Where slopes say what each promises.
    around: &'s Surroundings<'s>,
}

impl<'a> Look<'_, 'a> {
    fn trial(&self, candidate: &'a Candidate, index: usize) -> Result<Trial<'a>, NotTested> {
        // The first one is the best proposal, if they have an order.
        if 0 < index && self.context.monitor.is_stopped() {
            return Err(refused(candidate, "the diagnosis was stopped before"));
        }
        let trial = Trial::new(self.context.case.nominal, candidate, index, self.null);
        trial.map_err(|e| refused(candidate, &e.to_string()))
    }

    /// What each candidate promises, of which `promising` says whether it is looked at.
    fn screened(
        &self,
        model: &Model,
        promising: Option<&[bool]>,
    ) -> Result<Vec<Result<Screened<'a>, NotTested>>, FitError> {
        let Context { case, candidates, monitor, .. } = self.context;
        let candidates = candidates.simulated.as_slice();
        let lines = lines(self.null)?;
        let commands = Command::all(case.nominal, model, self.null, candidates);
        monitor.begin(Stage::Screen, candidates.len());
        Ok(each(candidates.iter().enumerate(), |(index, candidate)| {
            if promising.is_some_and(|promising| !promising[index]) {
                monitor.advance();
                return Err(too_little(candidate));
            }
            let screened = self.trial(candidate, index).map(|mut trial| {
                let command = Command::of_candidate(&commands, candidate);
                trial.screen(self.null, self.around, &lines, command);
                Screened::of(trial)
            });
            monitor.advance();
            screened
        }))
    }

    /// Short fits of those that promise most, and then of what may come near to what these have gained.
    fn fitted(
        &self,
        screened: Vec<Screened<'a>>,
        least: f64,
        not_tested: &mut Vec<NotTested>,
    ) -> Vec<Trial<'a>> {
        let Context { settings, monitor, .. } = self.context;
        let gains = screened.iter().map(|one| (one.candidate, one.gain()));
        let (promises, ranked) = of_causes(gains);
        let nth = |n: usize| ranked.get(n.saturating_sub(1)).copied().unwrap_or(0.0);
        let least = nth(settings.shortlist).max(least / MORE_THAN_PROMISED);
        let leading = nth(settings.finalists).max(least);
        monitor.begin(Stage::Fit, screened.len());
        let fit = |Screened { candidate, index, scored, .. }: Screened<'a>| {
            let mut trial = Trial { scored, ..self.trial(candidate, index)? };
            trial.first_fit(self.null, self.around);
            monitor.advance();
            let is_there = trial.best.is_some();
            if is_there { Ok(trial) } else { Err(diverges(candidate)) }
        };
        let (first, others): (Vec<_>, Vec<_>) =
            screened.into_iter().zip(promises).partition(|(_, promise)| leading <= *promise);
        let mut trials = tested(each(first, |(one, _)| fit(one)), not_tested);
        let best = trials.iter().map(Trial::cost).fold(self.null.minimum.cost, f64::min);
        let gained = self.null.minimum.cost - best;
        let is_from_here = is_of_the_fit(self.around, self.null);
        let others = each(others, |(one, promise)| {
            if promise < least || is_from_here && is_hopeless(promise, gained) {
                monitor.advance();
                let is_lost = one.scored.is_empty();
                return Err((if is_lost { diverges } else { too_little })(one.candidate));
            }
            fit(one)
        });
        trials.extend(tested(others, not_tested));
        trials.sort_by_key(|trial| trial.index);
        trials
    }
}

fn diverges(candidate: &Candidate) -> NotTested {
    refused(candidate, "its simulation diverges")
}

fn too_little(candidate: &Candidate) -> NotTested {
    refused(candidate, "others promise far more")
}

/// Why a candidate is not tried, or has no fit.
fn refused(candidate: &Candidate, reason: &str) -> NotTested {
    NotTested::of(candidate, reason.to_owned())
}

/// What was tested; why the rest was not goes to the others of that kind.
fn tested<T>(outcomes: Vec<Result<T, NotTested>>, not_tested: &mut Vec<NotTested>) -> Vec<T> {
    let keep = |outcome: Result<T, _>| outcome.map_err(|reason| not_tested.push(reason)).ok();
    outcomes.into_iter().filter_map(keep).collect()
}

/// Frequencies of the highest lines in the spectrum of what the null fit leaves, in Hz.
fn lines(null: &NullFit) -> Result<Vec<f64>, FitError> {
    let mut problem = null.problem.clone();
    let errors = problem.errors(&null.minimum.z).ok_or(FitError::Diverged)?;
    let signals: Vec<&[f64]> = errors.iter().flatten().map(Vec::as_slice).collect();
    let rate = 1.0 / problem.simulator().ts().seconds();
    Ok(spectral_peaks(&signals, LINES).into_iter().map(|f| f * rate).collect())
}
