//! Nothing comes near the noise: something is missing beside every explanation.
//!
//! Real logs end at 6 to 230 times the noise, whatever single effect is added. What is left is no noise: it is what
//! disturbances at places of the plant do to the outputs ([`beside`]). Explanations are compared by their evidence with that
//! beside them, and by the density of their forecasts of `held_out` logs, each with the sizes that suit it best.
//! "None of these" is the model without any effect beside what is unknown. Curves and paths are no explanations here, since
//! they draw what is unknown.

use fd_sim::{model::Model, simulate::Nominal};
use rayon::prelude::*;

use super::{
    horizons::{memory, windows},
    judged::{Judged, NamedPairs},
    probabilities::Probabilities,
    ties::ties,
    trust::{doubt, trust, trusted_first},
    verdict::verdict,
};
use crate::{
    diagnose::{
        candidates::follows_anything,
        context::Context,
        prepare::Prepared,
        result::{Cause, Regime},
        search::{
            finish, search,
            searched::{Searched, TrialId},
            trial::Trial,
        },
        settings::Settings,
        unknown::{Beside, beside},
        weigh::{
            Weighed,
            explain::settle,
            priors::Priors,
            rank::{Basis, RankedCause, Reference, weigh_law},
            singles::{Singles, weigh_singles},
            values::FittedValues,
        },
    },
    evidence::probabilities,
    fit::{FitError, Horizon, Log, Minimum, NullFit, Problem, minimise_all},
    shrink::forecast,
};

/// Rounds in which an explanation and what is beside it settle; the first is beside what is unknown without it.
const ROUNDS: usize = 3;

/// Judges by evidence beside something unknown.
pub(super) fn beyond<'a>(
    weighed: Weighed<'a>,
    held_out: &[Log],
    context: &Context<'a>,
) -> Result<Judged<'a>, FitError> {
    let settings = context.settings;
    let simulator = weighed.singles.base.simulator().boxed();
    let horizons = memory(&*simulator, &weighed.singles.searched.null, held_out);
    let windows = windows(&horizons);
    let beside_noise = weighed.singles.searched.null.clone();
    let mut singles = contest(weighed.singles.searched, (held_out, windows), context)?;
    let logs = if held_out.is_empty() { &singles.base.plan().logs } else { held_out };
    let nulls = [&beside_noise, &singles.searched.null];
    let trust = trust(&singles, nulls, logs, &horizons, settings)?;
    let trust = trusted_first(&mut singles.causes, trust);
    let mut believed = believe(&mut singles.causes, settings);
    believed.none_of_these += doubt(&mut singles.causes, &trust);
    let ties = ties(&singles.causes, &singles.searched, settings);
    let best = singles.first_answer().unwrap_or_else(|| singles.refit.clone());
    let lack_of_fit = singles.lack_of_fit(&best);
    let pairs = NamedPairs::default();
    Ok(Judged {
        verdict: verdict(believed, &singles.causes, &ties, &pairs),
        regime: Regime::AboveTheFloor,
        probabilities: believed,
        singles,
        ties,
        pairs,
        best,
        lack_of_fit,
        horizons,
    })
}

/// Laws with their evidence over that of the model without any effect, all beside what is unknown.
///
/// First beside what is unknown without any effect: then the unknown is largest, and the landscape smoothest. Then the
/// best laws each beside what is unknown besides them, at the places where something is.
fn contest<'a>(
    searched: Searched<'a>,
    (held_out, horizon): (&[Log], Horizon),
    context: &Context<'a>,
) -> Result<Singles<'a>, FitError> {
    let (nominal, finalists) = (context.case.nominal, context.settings.finalists);
    let Searched { model, null, noise, trials: known, .. } = searched;
    let (null, without) = unsettled(nominal, &model, null).ok_or(FitError::Diverged)?;
    let mut searched = search(Prepared { model, null, noise }, context)?;
    // Beside noise alone other valleys are found, which may be deeper here as well.
    searched.trials.par_iter_mut().for_each(|trial| {
        let same = known.iter().find(|known| known.index == trial.index);
        if let Some(best) = same.and_then(|same| same.best.as_ref()) {
            trial.start_at(&best.z);
        }
    });
    finish(&mut searched.trials, &searched.null, finalists);
    let mut singles = weigh_singles(searched, context)?;
    let Singles { causes, searched, reference, .. } = &mut singles;
    let null = &searched.null;
    let model = settle(&searched.model, &null.problem, &null.minimum.z);
    let mut forecast = Forecasts { nominal, logs: held_out, horizon, reference: 0.0 };
    forecast.reference = forecast.gain(&without, &model, (&null.problem, &null.minimum))?;
    // Curves and paths draw what is unknown, and causes of the measurement take the errors of one fit for noise.
    causes.retain(|ranked| match ranked.basis {
        Basis::Simulation(id) => {
            let is_law = !follows_anything(searched.trial(id).candidate);
            is_law && ranked.cause.log_evidence.is_finite()
        }
        Basis::Measurement(_) => false,
    });
    let best: Vec<Basis> = causes.iter().take(finalists).map(|ranked| ranked.basis).collect();
    let trials = searched.trials_mut().filter(|(id, _)| best.contains(&Basis::Simulation(*id)));
    let settled = trials.collect::<Vec<_>>().into_par_iter().map(|(id, trial)| {
        let law = Law { id, trial, reference, without: &without };
        Ok((Basis::Simulation(id), law.settled(&forecast)?))
    });
    let settled = settled.collect::<Result<Vec<(Basis, Option<Cause>)>, FitError>>()?;
    let mut least = f64::INFINITY;
    for ranked in causes.iter_mut() {
        match settled.iter().find(|(basis, _)| *basis == ranked.basis) {
            Some((_, Some(cause))) => {
                // What the laws of a cause have together, over the best of them, stays.
                let log_evidence = ranked.cause.log_evidence + cause.log_evidence;
                ranked.cause = Cause { log_evidence, ..cause.clone() };
                least = least.min(log_evidence);
            }
            // Nothing is known of its forecasts: it comes behind those of which something is.
            _ => ranked.cause.log_evidence = ranked.cause.log_evidence.min(least),
        }
    }
    causes.sort_by(|a, b| b.cause.log_evidence.total_cmp(&a.cause.log_evidence));
    Ok(singles)
}

/// The fit without any effect beside what is unknown then.
fn unsettled(nominal: &dyn Nominal, model: &Model, null: NullFit) -> Option<(NullFit, Beside)> {
    let NullFit { mut problem, minimum: Minimum { z, .. } } = null;
    let found = beside(nominal, &settle(model, &problem, &z), &problem, &z, None)?;
    problem.set_weights(found.weights.clone());
    let search = problem.search();
    let origin = vec![0.0; z.len()];
    let fits = minimise_all(&mut problem, &[z, origin], None, search).into_iter().flatten();
    let minimum = fits.min_by(|a, b| a.cost.total_cmp(&b.cost))?.shared(&problem);
    Some((NullFit { problem, minimum }, found))
}

/// A law that was fitted beside what is unknown without it.
struct Law<'l, 'a> {
    id: TrialId,
    trial: &'l mut Trial<'a>,
    reference: &'l Reference,
    without: &'l Beside,
}

impl Law<'_, '_> {
    /// The law beside what is unknown besides it, as its cause, with the evidence that it has more than at first;
    /// `None` when it cannot be simulated.
    fn settled(self, forecast: &Forecasts<'_>) -> Result<Option<Cause>, FitError> {
        let Self { id, trial, reference, without } = self;
        let mut found = without.clone();
        let mut first = None;
        let mut best: Option<(Cause, Problem, Option<Minimum>)> = None;
        for _ in 0..ROUNDS {
            let cause = weigh_law(id, trial, reference).cause;
            let Some(at) = &trial.best else { break };
            let model = cause.model.clone();
            let first = *first.get_or_insert(cause.log_evidence);
            let gain = forecast.gain(&found, &model, (&trial.problem, at))?;
            let log_evidence = cause.log_evidence + gain - first;
            if best.as_ref().is_some_and(|(before, ..)| log_evidence <= before.log_evidence) {
                break;
            }
            let problem = trial.problem.clone();
            best = Some((Cause { log_evidence, ..cause }, problem, trial.best.clone()));
            let places = Some(&without.places[..]);
            let next = beside(forecast.nominal, &model, &trial.problem, &at.z, places);
            let Some(next) = next else { break };
            trial.full_fit_with(&next.weights);
            found = next;
        }
        Ok(best.map(|(cause, problem, at)| {
            (trial.problem, trial.best) = (problem, at);
            cause
        }))
    }
}

/// Forecasts of held-out logs.
struct Forecasts<'a> {
    nominal: &'a dyn Nominal,
    logs: &'a [Log],
    horizon: Horizon,
    /// Logarithm of the density of the logs without any effect.
    reference: f64,
}

impl Forecasts<'_> {
    /// Logarithm of the density of the logs over the reference; zero where there are none, or what is unknown cannot be
    /// simulated there.
    fn gain(
        &self,
        found: &Beside,
        model: &Model,
        (problem, at): (&Problem, &Minimum),
    ) -> Result<f64, FitError> {
        let Self { nominal, logs, horizon, reference } = *self;
        if logs.is_empty() {
            return Ok(0.0);
        }
        let simulator = nominal.simulator(problem.simulator().ts())?;
        let values = FittedValues::of(problem, at);
        let sigma = &problem.weights().sigma;
        let forecast = forecast(&*simulator, values.settled(), logs, horizon, sigma)?;
        let Some(forecast) = forecast else { return Ok(f64::NEG_INFINITY) };
        let density = found.log_density(nominal, model, problem, logs, &forecast);
        Ok(density.map_or(0.0, |density| density - reference))
    }
}

/// Gives causes their probabilities, and "none of these" the rest.
fn believe(causes: &mut [RankedCause], settings: &Settings) -> Probabilities {
    let priors = Priors::of(settings, causes.len());
    let prior = priors.no_gap * settings.unknown / (1.0 - settings.unknown);
    let mut answers = vec![(0.0, prior)];
    answers.extend(causes.iter().map(|ranked| (ranked.cause.log_evidence, priors.cause)));
    let found = probabilities(&answers, settings.temperature);
    causes.iter_mut().zip(&found[1..]).for_each(|(r, p)| r.cause.probability = *p);
    Probabilities { no_gap: 0.0, none_of_these: found[0] }
}
