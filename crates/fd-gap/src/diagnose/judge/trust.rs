//! How far a law may be believed that leaves much unexplained.
//!
//! Evidence compares laws with each other. Where the right one is in no library, the best of them is a mimic, however
//! far it is ahead. What can be said then is how much of other data it stands for: the rest is the work of something
//! else, and a law is believed up to the share of the variance that it surely explains in forecasts.

use super::super::{
    settings::Settings,
    weigh::{
        rank::{Basis, RankedCause},
        singles::Singles,
        values::FittedValues,
    },
};
use super::verdict::NAMED;
use crate::{
    fit::{FitError, Horizon, Log, Minimum, NullFit, Problem},
    quality::noise_floor,
    shrink::{closed, forecast_errors, gap, gap_per_output},
};

/// Trust in a law of which forecasts show nothing.
const LEAST: f64 = 0.05;

/// The share of the variance above the noise that each of the first causes surely explains (with 97.5 %) in forecasts of
/// logs, at the horizon that suits it best; beside the best of these fits without any effect.
pub(super) fn trust(
    singles: &Singles<'_>,
    without: [&NullFit; 2],
    logs: &[Log],
    horizons: &[Horizon],
    settings: &Settings,
) -> Result<Vec<f64>, FitError> {
    let searched = &singles.searched;
    let sigma = &searched.noise.sigma;
    let forecasts = |problem: &Problem, at: &Minimum| {
        let values = FittedValues::of(problem, at);
        let nominal = singles.base.simulator();
        let each = horizons.iter();
        each.map(|horizon| forecast_errors(nominal, values.settled(), logs, *horizon, sigma))
            .collect::<Result<Vec<_>, _>>()
    };
    let [one, other] = without.map(|null| forecasts(&null.problem, &null.minimum));
    let before = one?.into_iter().zip(other?).map(|pair| match pair {
        (Some(one), Some(other)) => Some(if gap(&one) < gap(&other) { one } else { other }),
        (one, other) => one.or(other),
    });
    let before: Vec<_> = before.collect();
    let share = |ranked: &RankedCause| {
        let Basis::Simulation(id) = ranked.basis else { return Ok(LEAST) };
        let trial = searched.trial(id);
        let Some(at) = &trial.best else { return Ok(LEAST) };
        let after = forecasts(&trial.problem, at)?;
        let shares = before.iter().zip(&after).filter_map(|(before, after)| {
            let (before, after) = (before.as_ref()?, after.as_ref()?);
            let floors = after
                .iter()
                .map(|signals| noise_floor(&signals.join(&f64::NAN), None).unwrap_or(1.0).powi(2));
            let floor = f64::sqrt(floors.sum::<f64>() / gap_per_output(after).len().max(1) as f64);
            let found = closed(before, after, floor, settings.replicas, settings.seed)?;
            Some(1.0 - (1.0 - found.interval[0].clamp(0.0, 1.0)).powi(2))
        });
        Ok(shares.fold(LEAST, f64::max))
    };
    singles.causes.iter().take(settings.finalists).map(share).collect()
}

/// Puts causes that may be named behind none that may not: what forecasts little draws the logs that it was fitted to, as
/// curves do, and has no evidence over one that forecasts. Returns the trust in their new order.
pub(super) fn trusted_first(causes: &mut Vec<RankedCause>, trust: Vec<f64>) -> Vec<f64> {
    let trust = trust.into_iter().chain(std::iter::repeat(LEAST));
    let (named, mut others): (Vec<_>, Vec<_>) =
        causes.drain(..).zip(trust).partition(|(_, trust)| NAMED < *trust);
    let evidence = named.iter().map(|(ranked, _)| ranked.cause.log_evidence);
    let least = evidence.fold(f64::INFINITY, f64::min);
    for (ranked, _) in &mut others {
        ranked.cause.log_evidence = ranked.cause.log_evidence.min(least);
    }
    let all: (Vec<_>, Vec<_>) = named.into_iter().chain(others).unzip();
    *causes = all.0;
    all.1
}

/// Believes causes no more than they are trusted; what is taken from them.
pub(super) fn doubt(causes: &mut [RankedCause], trust: &[f64]) -> f64 {
    let mut doubt = 0.0;
    for (ranked, trust) in causes.iter_mut().zip(trust) {
        let believed = ranked.cause.probability;
        ranked.cause.probability *= trust;
        doubt += believed - ranked.cause.probability;
    }
    doubt
}
