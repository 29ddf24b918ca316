//! What could be told from a case without noise, by refits to its noise-free truth.

use fd_effect::{Candidate, Suspects};
use fd_gap::fit::FitError;
use fd_sim::model::{Draft, LoadError, Model};

use super::{
    error::BlindError,
    logs::{LogOfRun, Part},
    refit::{Fitted, Sight, simulated},
    rival::{Oracle, Rival},
    truth::{Scene, Truth},
};

/// Squares of the noise below which two explanations are one.
pub(super) const SEPARATED: f64 = 9.0;

/// Tolerance of a free start, in spreads of the state.
const FREE: f64 = 10.0;
/// What is left where no fit is possible: as much as can be written.
const BEYOND: f64 = 1e15;
/// Laws of one of two effects beside which the other is fitted.
const FIRSTS: usize = 2;

/// What the nominal model leaves at least of the noise-free truth.
///
/// The real parameters lie somewhere within their tolerance. The box of a diagnosis has the nominal
/// ones in its middle, so that it reaches further on one side than a box around the truth. What it
/// can reach there, nobody who knows no more than the model file can call an effect: there counts
/// what the effect adds to the least squares of the same run without it.
fn nothing(scene: &Scene<'_>, at_truth: f64, clean: &LogOfRun) -> Result<f64, BlindError> {
    let (truth, model) = (scene.truth, scene.model);
    let without = Truth { effects: Vec::new(), ..truth.clone() };
    let without = Scene::new(&without, model)?.log_of(0, Part::First, false)?;
    let Some(without) = without else { return Ok(at_truth) };
    let cost = |log: &LogOfRun| -> Result<Option<f64>, BlindError> {
        let model = seen(scene, log, model.clone().into_draft())?;
        Ok(Sight::new(scene, &model, &log.record)?.null()?.map(|null| null.minimum.cost))
    };
    let (Some(with), Some(without)) = (cost(clean)?, cost(&without)?) else { return Ok(at_truth) };
    Ok(at_truth.min((with - without).max(0.0)))
}

/// The model with real parameters and initial states for nominal ones: distances are measured from
/// where the truth is, as the tie test of the diagnosis does.
fn centred(scene: &Scene<'_>, log: &LogOfRun) -> Result<Model, BlindError> {
    let mut draft = scene.model.clone().into_draft();
    for (parameter, value) in draft.parameters.iter_mut().zip(&scene.truth.parameters) {
        parameter.tolerance *= (parameter.value / value).abs();
        parameter.value = *value;
    }
    for (state, value) in draft.states.iter_mut().zip(&log.start) {
        state.initial = *value;
    }
    seen(scene, log, draft)
}

/// A model as a log lets it be seen: with the noise that the logger adds, and with a free start
/// where the log begins in motion or is looked at in windows.
fn seen(scene: &Scene<'_>, log: &LogOfRun, mut draft: Draft) -> Result<Model, BlindError> {
    for (output, sigma) in draft.outputs.iter_mut().zip(scene.sigma()) {
        output.noise = Some(sigma);
    }
    if Sight::window(scene).is_some() {
        // Windows begin about where the plant is held.
        let held: Vec<f64> = draft.states.iter().map(|state| state.initial).collect();
        let states = draft.states.iter_mut().zip(&log.spread);
        for ((state, spread), initial) in states.zip(held) {
            (state.initial, state.tolerance) = (initial, Some(free(*spread, initial)));
        }
    } else if 0 < scene.truth.conditions.before {
        start_freely(&mut draft, log);
    }
    checked(draft)
}

/// A model whose states start wherever a log does.
pub(super) fn free_start(model: &Model, log: &LogOfRun) -> Result<Model, BlindError> {
    let mut draft = model.clone().into_draft();
    start_freely(&mut draft, log);
    checked(draft)
}

fn start_freely(draft: &mut Draft, log: &LogOfRun) {
    let starts = draft.states.iter_mut().zip(log.start.iter().zip(&log.spread));
    for (state, (start, spread)) in starts {
        (state.initial, state.tolerance) = (*start, Some(free(*spread, *start)));
    }
}

fn free(spread: f64, start: f64) -> f64 {
    FREE * spread.max(1e-3 * start.abs()).max(1e-9)
}

fn checked(draft: Draft) -> Result<Model, BlindError> {
    Model::try_from(draft).map_err(|error| {
        let file = "the model at the truth".to_owned();
        BlindError::Model { error: Box::new(LoadError::Model { file, error }) }
    })
}

/// What the best fit of the nominal model about the truth leaves of the noise-free log; infinite
/// when either diverges.
pub(super) fn left_by_nothing(truth: &Truth, model: &Model) -> Result<f64, BlindError> {
    let scene = Scene::new(truth, model)?;
    let Some(log) = scene.log_of(0, Part::First, false)? else { return Ok(f64::INFINITY) };
    let model = centred(&scene, &log)?;
    let null = Sight::new(&scene, &model, &log.record)?.null()?;
    Ok(null.map_or(f64::INFINITY, |null| null.minimum.cost))
}

/// What could be told from the noise-free log of a scene; with `rivals`, everything in the library
/// that explains it.
pub(super) fn oracle(scene: &Scene<'_>, rivals: bool) -> Result<Oracle, BlindError> {
    let Some(log) = scene.log_of(0, Part::First, false)? else {
        return Err(FitError::Diverged.into());
    };
    let model = centred(scene, &log)?;
    let sight = Sight::new(scene, &model, &log.record)?;
    // A log that is read wrongly may be beyond all fits.
    let Some(null) = sight.null()? else {
        return Ok(Oracle { nothing: BEYOND, ..Oracle::default() });
    };
    let nothing = nothing(scene, null.minimum.cost, &log)?;
    let mut oracle = Oracle { nothing, ..Oracle::default() };
    if nothing < SEPARATED || !rivals {
        return Ok(oracle);
    }
    let candidates = simulated(sight.suspects().alone());
    let mut rivals: Vec<Rival> = Vec::new();
    for Fitted { candidate, minimum, .. } in sight.fitted(candidates, &null) {
        let distance = minimum.cost;
        let rival = Rival { distance, ..Rival::of(&candidate) };
        match rivals.iter_mut().find(|known| known.is_same(&rival)) {
            Some(known) if distance < known.distance => *known = rival,
            Some(_) => {}
            None => rivals.push(rival),
        }
    }
    rivals.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    oracle.best = rivals.first().cloned();
    rivals.retain(|rival| rival.distance < SEPARATED);
    oracle.ties = rivals;
    Ok(oracle)
}

/// The least that named effects leave, over all their laws and starts; more than two are taken one after another in
/// their order, each of them first once.
pub(super) fn distance_of(
    scene: &Scene<'_>,
    wanted: &[&dyn Fn(&Candidate) -> bool],
) -> Result<f64, BlindError> {
    let Some(log) = scene.log_of(0, Part::First, false)? else { return Ok(f64::INFINITY) };
    let model = centred(scene, &log)?;
    let sight = Sight::new(scene, &model, &log.record)?;
    let Some(null) = sight.null()? else { return Ok(f64::INFINITY) };
    let suspects = sight.suspects();
    let mut least = null.minimum.cost;
    for (i, first) in wanted.iter().enumerate() {
        let alone = simulated(suspects.alone()).filter(|candidate| first(candidate));
        for fit in sight.fitted(alone, &null).into_iter().take(FIRSTS) {
            least = least.min(fit.minimum.cost);
            if wanted.len() == 2 {
                let second = wanted[1 - i];
                let beside = simulated(suspects.beside(&fit.candidate)).filter(|c| second(c));
                let both = sight.fitted(beside, &fit.granted()?);
                least = both.first().map_or(least, |both| least.min(both.minimum.cost));
            } else {
                let others = [&wanted[..i], &wanted[i + 1..]].concat();
                least = least.min(chain(&sight, fit, &others)?);
            }
        }
    }
    Ok(least)
}

/// What is left when the others of a list are fitted one after the other beside a first one.
fn chain(
    sight: &Sight<'_>,
    first: Fitted,
    others: &[&dyn Fn(&Candidate) -> bool],
) -> Result<f64, BlindError> {
    let suspects = sight.suspects();
    let (mut so_far, mut least) = (first, f64::INFINITY);
    for next in others {
        let beside = simulated(suspects.beside(&so_far.candidate)).filter(|c| next(c));
        let Some(best) = sight.fitted(beside, &so_far.granted()?).into_iter().next() else { break };
        least = least.min(best.minimum.cost);
        so_far = best;
    }
    Ok(least)
}
