//! Nothing comes near the noise: something is missing beside every explanation.
//!
//! Real logs end at 6 to 230 times the noise, whatever single effect is added. What is left is no noise: it is what
//! disturbances at places of the plant do to the outputs ([`beside`]). Explanations are compared by their evidence with that
//! beside them, and by the density of their forecasts of `held_out` logs, each with the sizes that suit it best.
//! "None of these" is the model without any effect beside what is unknown. Curves and paths are no explanations here, since
//! they draw what is unknown.

use rayon::prelude::*;

use super::{
    horizons::memory,
    judged::{Judged, NamedPairs},
    probabilities::Probabilities,
    ties::ties,
    verdict::verdict,
};
use crate::{
    diagnose::{
        candidates::follows_anything,
        context::Context,
        result::Regime,
        search::{
            finish,
            searched::{Searched, TrialId},
        },
        unknown::{Beside, beside},
        weigh::{
            Weighed,
            explain::settle,
            priors::Priors,
            rank::{Basis, RankedCause},
            singles::{Singles, weigh_singles},
            values::FittedValues,
        },
    },
    evidence::probabilities,
    fit::{FitError, Horizon, Log, Minimum, Problem, Weights, null_fit},
    shrink::forecast_errors,
};

/// Rounds in which the explanation and what is beside it settle. The first has what is beside no effect at all: then the
/// unknown is largest, and the landscape smoothest.
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
    let Contested { singles, unknown } = contest(weighed.singles.searched, held_out, context)?;
    let Singles { causes, .. } = singles;
    let (causes, believed) = believe(causes, unknown, context);
    let singles = Singles { causes, ..singles };
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

/// Laws with their evidence.
struct Contested<'a> {
    singles: Singles<'a>,
    /// Evidence of the model without any effect.
    unknown: f64,
}

/// Weighs laws beside what is unknown with no effect, then beside what is unknown with the best one, until that stays.
fn contest<'a>(
    mut searched: Searched<'a>,
    held_out: &[Log],
    context: &Context<'a>,
) -> Result<Contested<'a>, FitError> {
    let nominal = context.case.nominal;
    let sigma = searched.noise.sigma.clone();
    let null = &searched.null;
    let mut model = settle(&searched.model, &null.problem, &null.minimum.z);
    let (mut problem, mut z) = (null.problem.clone(), null.minimum.z.clone());
    let (mut table, mut unknown) = (Vec::new(), f64::NEG_INFINITY);
    let mut first = None;
    let verbose = std::env::var_os("FDIAG_TRACE").is_some();
    let start = std::time::Instant::now();
    for round in 1.. {
        let found = beside(nominal, &model, &problem, &z, &sigma).ok_or(FitError::Diverged)?;
        if verbose {
            eprintln!("{:?} round {round}: noise {:?} of {sigma:?}, unknown at {:?}", start.elapsed(), found.weights.sigma, found.places);
        }
        searched = reweighed(searched, &found.weights, context.settings.finalists)?;
        if verbose {
            eprintln!("{:?} refitted", start.elapsed());
        }
        let singles = weigh_singles(searched, context)?;
        let forecast = Forecast::new(&found, &model, &problem, held_out, context)?;
        let null = &singles.searched.null;
        let without = forecast.log_density(&null.problem, &null.minimum)?;
        unknown = unknown.max(singles.reference.log_evidence + without);
        let weighed = singles.causes.par_iter().filter_map(|ranked| {
            let (id, problem, at) = law(&singles, ranked)?;
            let is_final = singles.searched.trial(id).is_final;
            let density =
                if is_final { forecast.log_density(problem, at) } else { Ok(without) };
            let evidence = singles.reference.log_evidence + ranked.cause.log_evidence;
            Some(density.map(|density| (id, evidence + density)))
        });
        let weighed = weighed.collect::<Result<Vec<(TrialId, f64)>, _>>()?;
        if verbose {
            let mut sorted: Vec<_> = weighed.iter().collect();
            sorted.sort_by(|a, b| b.1.total_cmp(&a.1));
            for (id, e) in sorted.iter().take(8) {
                let c = singles.searched.trial(*id);
                let ev = singles.causes.iter().find(|r| r.basis == Basis::Simulation(*id)).map_or(0.0, |r| r.cause.log_evidence);
                eprintln!("  {} {:?} {}: {:.1} of which fitted {:.1}", c.candidate.label, c.candidate.site, c.candidate.law, e - singles.reference.log_evidence - without, ev);
            }
            eprintln!("{:?} weighed; reference {:.1} + {without:.1}", start.elapsed(), singles.reference.log_evidence);
        }
        let best = weighed.iter().max_by(|a, b| a.1.total_cmp(&b.1)).map(|(id, _)| *id);
        table.extend(weighed);
        let is_settled = first == best || ROUNDS <= round;
        first = best;
        if let Some((next, at)) = first.filter(|_| !is_settled).and_then(|id| {
            let trial = singles.searched.trial(id);
            Some((trial, trial.best.as_ref()?))
        }) {
            model = settle(&next.model, &next.problem, &at.z);
            (problem, z) = (next.problem.clone(), at.z.clone());
            searched = singles.searched;
            continue;
        }
        let best = |ranked: RankedCause| {
            let (id, ..) = law(&singles, &ranked)?;
            let own = table.iter().filter(|(known, _)| *known == id);
            let evidence = own.map(|(_, evidence)| *evidence).fold(f64::NEG_INFINITY, f64::max);
            let log_evidence = evidence - unknown;
            let cause = crate::diagnose::Cause { log_evidence, ..ranked.cause };
            log_evidence.is_finite().then_some(RankedCause { cause, ..ranked })
        };
        let mut causes: Vec<RankedCause> =
            singles.causes.clone().into_iter().filter_map(best).collect();
        causes.sort_by(|a, b| b.cause.log_evidence.total_cmp(&a.cause.log_evidence));
        return Ok(Contested { singles: Singles { causes, ..singles }, unknown });
    }
    Err(FitError::Diverged)
}

/// The fit of a cause that is a law of the simulation.
fn law<'s>(
    singles: &'s Singles<'_>,
    ranked: &RankedCause,
) -> Option<(TrialId, &'s Problem, &'s Minimum)> {
    let Basis::Simulation(id) = ranked.basis else { return None };
    let trial = singles.searched.trial(id);
    let best = trial.best.as_ref().filter(|_| !follows_anything(trial.candidate))?;
    Some((id, &trial.problem, best))
}

/// Forecasts of held-out logs, and what is unknown of them.
struct Forecast<'a> {
    nominal: Box<dyn fd_sim::simulate::Simulator>,
    logs: &'a [Log],
    unknown: Option<crate::diagnose::unknown::Forecasts>,
}

impl<'a> Forecast<'a> {
    fn new(
        found: &Beside,
        model: &fd_sim::model::Model,
        problem: &Problem,
        logs: &'a [Log],
        context: &Context<'_>,
    ) -> Result<Self, FitError> {
        let nominal = problem.simulator().ts();
        let nominal = context.case.nominal.simulator(nominal)?;
        let unknown = (!logs.is_empty())
            .then(|| found.of_forecasts(context.case.nominal, model, problem, logs))
            .flatten();
        Ok(Self { nominal, logs, unknown })
    }

    /// Logarithm of the density of the logs; zero where there are none, or what is unknown cannot be simulated there.
    fn log_density(&self, problem: &Problem, at: &Minimum) -> Result<f64, FitError> {
        let Some(unknown) = &self.unknown else { return Ok(0.0) };
        let values = FittedValues::of(problem, at);
        let settled = values.settled();
        let free = Horizon::FreeRun;
        let errors = forecast_errors(&*self.nominal, settled, self.logs, free, &unknown.sigma)?;
        Ok(errors.map_or(f64::NEG_INFINITY, |errors| unknown.log_density(&errors)))
    }
}

/// Gives causes their probabilities, and "none of these" the rest.
fn believe(
    mut causes: Vec<RankedCause>,
    _unknown: f64,
    context: &Context<'_>,
) -> (Vec<RankedCause>, Probabilities) {
    let settings = context.settings;
    let priors = Priors::of(settings, causes.len());
    let prior = priors.no_gap * settings.unknown / (1.0 - settings.unknown);
    let mut answers = vec![(0.0, prior)];
    answers.extend(causes.iter().map(|ranked| (ranked.cause.log_evidence, priors.cause)));
    let found = probabilities(&answers, settings.temperature);
    causes.iter_mut().zip(&found[1..]).for_each(|(r, p)| r.cause.probability = *p);
    (causes, Probabilities { no_gap: 0.0, none_of_these: found[0] })
}

/// The same search with other weights: everything is fitted again.
fn reweighed<'a>(
    searched: Searched<'a>,
    weights: &Weights,
    finalists: usize,
) -> Result<Searched<'a>, FitError> {
    let Searched { null: before, mut trials, mut noise, .. } = searched;
    noise.sigma.clone_from(&weights.sigma);
    let null = null_fit(before.problem.plan(), before.problem.simulator(), weights)?;
    trials.par_iter_mut().for_each(|trial| trial.reweigh(weights));
    let least = trials.iter().map(|trial| trial.cost()).fold(f64::INFINITY, f64::min);
    trials.par_iter_mut().for_each(|trial| trial.recolour(&null, weights, least));
    finish(&mut trials, &null, finalists);
    Ok(Searched { null, trials, noise, ..searched })
}
