//! What forecasts of held-out logs say about an explanation.
//!
//! What explains the logs of the fit and nothing else is no law: a curve over time follows any
//! force that comes from somewhere else, and a hundred candidates have a hundred chances. A law of
//! the wrong kind forecasts another run badly; the right one with a slightly different law does
//! not. A fit alone tells the two apart only when it leaves something.

use crate::{
    diagnose::{
        context::Context,
        settings::{LEADING, Settings},
        weigh::{
            answer::{Answer, Fit},
            rank::Basis,
            singles::Singles,
            values::FittedValues,
        },
    },
    fit::{FitError, Log, Minimum, Problem},
    quality::Autoregression,
    shrink::{Closed, Paths, closed, forecast_errors, gap_per_output},
};

/// An explanation that surely closes less than this share of a held-out gap does not forecast it, and
/// two causes where they most probably do: together they can draw much that is neither.
const CLOSES_LITTLE: f64 = 0.7;

/// Spread of `ln` of the noise from one run to another.
const BETWEEN_RUNS: f64 = 0.05;

/// What it costs, in log-likelihood, that the `best` answer misses held-out logs by more than the noise, of which `floor` is the
/// size, and than the fitted ones; nothing where it closes a good part of the held-out gap. A free curve may forecast badly
/// where a law that fits as well does not: where the best answer, of one effect, forecasts badly, it is the best of it and
/// its rivals.
pub(super) fn validate_with_rivals(
    best: &Answer,
    floor: &[f64],
    singles: &Singles<'_>,
    held_out: &[Log],
    context: &Context<'_>,
) -> Result<f64, FitError> {
    let settings = context.settings;
    let validate =
        |answer: &Answer, paths| validate(answer, floor, singles, held_out, settings, paths);
    let mut loss = validate(best, Paths::AsFitted)?;
    if 0.0 < loss && best.effects == 1 {
        let near = best.log_evidence - settings.bayes_factor.ln();
        let others = singles.causes.iter().skip(1);
        let rivals = others.take_while(|ranked| near < ranked.cause.log_evidence);
        for ranked in rivals.take(LEADING) {
            let Basis::Simulation(id) = ranked.basis else { continue };
            let Some(rival) = singles.answer_of(id, ranked.cause.log_evidence) else { continue };
            loss = loss.min(validate(&rival, Paths::AsFitted)?);
        }
    }
    // A path is that of one run; that no law forecasts where it does not has been seen.
    let paths = best.fit.as_ref().map_or(Paths::AsFitted, Fit::paths);
    if 0.0 < loss && paths == Paths::Anew {
        loss = loss.min(validate(best, paths)?);
    }
    Ok(loss)
}

/// The same of one answer, at the first horizon of the report; nothing where it has no simulated effects, there is no held-out
/// log, or no gap in it.
pub(super) fn validate(
    answer: &Answer,
    floor: &[f64],
    singles: &Singles<'_>,
    held_out: &[Log],
    settings: &Settings,
    paths: Paths,
) -> Result<f64, FitError> {
    let (Some(fit), Some(horizon)) = (&answer.fit, settings.report_horizons.first()) else {
        return Ok(0.0);
    };
    if held_out.is_empty() {
        return Ok(0.0);
    }
    let (nominal, searched) = (singles.base.simulator(), &singles.searched);
    let run = |problem: &Problem, at: &Minimum| {
        let values = FittedValues::of(problem, at).with_paths(paths);
        forecast_errors(nominal, values.settled(), held_out, *horizon, &searched.noise.sigma)
    };
    let before = run(&searched.null.problem, &searched.null.minimum)?;
    let after = run(&fit.problem, &fit.minimum)?;
    let (Some(before), Some(after)) = (before, after) else {
        return Ok(0.0);
    };
    let squares: f64 = floor.iter().map(|floor| floor * floor).sum();
    let all = f64::sqrt(squares / floor.len().max(1) as f64);
    let share = closed(&before, &after, all, settings.replicas, settings.seed);
    let Some(Closed { fraction, interval: [_, high], .. }) = share.map(Closed::between_runs) else {
        return Ok(0.0);
    };
    // What forecasts no better than no cause at all is not excused by a wide interval.
    let is_harmless = CLOSES_LITTLE < if answer.effects < 2 { high } else { fraction };
    if is_harmless && 0.0 < fraction {
        return Ok(0.0);
    }
    let fitted = gap_per_output(&answer.errors);
    let expected = fitted.iter().zip(floor).map(|(fitted, floor)| fitted.max(*floor));
    Ok(after.iter().zip(expected).map(|(errors, expected)| raised(errors, expected)).sum())
}

/// What it costs that the errors of an output are stronger than expected.
fn raised(errors: &[Vec<f64>], expected: f64) -> f64 {
    let n = errors.iter().flatten().filter(|e| e.is_finite()).count().max(1) as f64;
    let squares: f64 = errors.iter().flatten().filter(|e| e.is_finite()).map(|e| e * e).sum();
    let above = 0.5 * (squares / n / expected.powi(2)).ln();
    let signals: Vec<&[f64]> = errors.iter().map(Vec::as_slice).collect();
    // Slow errors are few independent ones, roughly n g² of them.
    let innovation = Autoregression::fit(&signals, Autoregression::HIGHEST_ORDER).innovation();
    let chance = 0.5 / (n * innovation * innovation);
    if above <= 0.0 { 0.0 } else { 0.5 * above.powi(2) / (chance + BETWEEN_RUNS.powi(2)) }
}
