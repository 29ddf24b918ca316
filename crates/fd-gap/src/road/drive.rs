//! Along the road.

use fd_effect::{Candidate, Suspects};
use fd_sim::model::Model;

use super::{
    adjustable::{With, adjustable},
    beside::Beside,
    eliminate::{Eliminated, Judge, Refitted},
    result::{End, Milestone, Road},
};
use crate::{
    diagnose::{
        Case, Cause, Diagnosis, HeldOut, Monitor, Objection, Regime, Settings, Verdict, diagnose,
        is_free_curve,
    },
    fit::{FitError, Horizon},
    shrink::{Closed, closed, gap},
};

/// Goes on from a diagnosis as long as causes help, to `most` causes. `None` where one answer is
/// all there is to say: there is no gap, one cause or one pair explains the logs down to the noise, the loop was
/// diagnosed with its controller on logged outputs, or nothing helps at all.
///
/// # Errors
///
/// As [`diagnose`].
pub fn road(
    case: &Case<'_>,
    first: &Diagnosis,
    settings: &Settings,
    most: usize,
    monitor: &dyn Monitor,
) -> Result<Option<Road>, FitError> {
    let is_named = matches!(first.verdict, Verdict::Cause | Verdict::Tied | Verdict::Pair);
    let is_explained = first.regime == Regime::AtTheFloor && (is_named || !first.is_unexplained);
    if is_explained || first.is_logged_loop || first.verdict == Verdict::NoGap {
        return Ok(None);
    }
    let mut found: Vec<Milestone> = Vec::new();
    let mut known: Vec<Candidate> = Vec::new();
    let horizon = judged_at(first, settings);
    let sized = |diagnosis: &Diagnosis, of: fn(&HeldOut) -> &Vec<f64>| {
        total(at(diagnosis, horizon), &first.sigma, of)
    };
    let mut gaps = vec![sized(first, |h| &h.refit)];
    let mut model = case.nominal.model().clone();
    let mut diagnosis = first.clone();
    let parameters: Vec<String> = model.parameters.iter().map(|p| p.name.clone()).collect();
    let end = loop {
        if found.len() == most {
            break End::Enough;
        }
        let Some((next, candidate)) = accepted(&diagnosis, horizon, case.suspects, &known) else {
            break if is_noise(&diagnosis) { End::AtTheNoise } else { End::NothingHelps };
        };
        gaps.push(sized(&diagnosis, |h| &h.after));
        model = adjustable(&next.cause, &model);
        let is_curve = is_free_curve(&candidate);
        known.push(Candidate { model: model.clone(), ..candidate });
        found.push(next);
        if is_curve {
            break End::AtACurve;
        }
        let suspects = Beside { suspects: case.suspects, known: &known, parameters: &parameters };
        let nominal = With { nominal: case.nominal, model: model.clone() };
        let here = Case { nominal: &nominal, suspects: &suspects, ..*case };
        diagnosis = diagnose(&here, settings, monitor)?;
        if diagnosis.verdict == Verdict::NoGap {
            break End::AtTheNoise;
        }
    };
    if found.is_empty() {
        return Ok(None);
    }
    finish(case, settings, Found { causes: found, model, gaps, end, first, horizon })
}

/// What was found on the way.
struct Found<'a> {
    causes: Vec<Milestone>,
    model: Model,
    /// Held-out gap without any cause, and after each, in sigma; NaN where it is not known.
    gaps: Vec<f64>,
    end: End,
    first: &'a Diagnosis,
    /// Horizon at which forecasts judge.
    horizon: Option<Horizon>,
}

/// Looks back: which causes are missed, what each takes away, and what all of them leave.
fn finish(
    case: &Case<'_>,
    settings: &Settings,
    Found { mut causes, model, gaps, end, first, horizon }: Found<'_>,
) -> Result<Option<Road>, FitError> {
    let plain = |causes, model| {
        let (dropped, closed) = (Vec::new(), None);
        Road { causes, unexplained: f64::NAN, noise: f64::NAN, closed, end, dropped, model }
    };
    let Some(horizon) = horizon else { return Ok(Some(plain(causes, model))) };
    let sigma = &first.sigma;
    let floor = total(at(first, Some(horizon)), sigma, |h| &h.floor);
    for (cause, gap) in causes.iter_mut().zip(gaps.windows(2)) {
        cause.share = Some((gap[0] - gap[1]) / gaps[0]);
    }
    let judge = Judge { case, settings, horizon, sigma, floor };
    let Eliminated { model, refitted, dropped } = judge.eliminate(model, &mut causes)?;
    let (Some(before), Some(after)) = (judge.refitted(case.nominal.model())?, refitted) else {
        return Ok(Some(Road { dropped, ..plain(causes, model) }));
    };
    let Refitted { errors: after, model } = after;
    let before = before.errors;
    let left = (gap(&after) / gap(&before)).min(1.0);
    let noise = (floor / gap(&before)).min(left);
    // Shares of the way there; what was dropped is left to the others.
    let kept: f64 = causes.iter().filter_map(|cause| cause.share).sum();
    for share in causes.iter_mut().filter_map(|cause| cause.share.as_mut()) {
        *share *= if 0.0 < kept { (1.0 - left) / kept } else { 1.0 };
    }
    let closed = closed(&before, &after, floor, settings.replicas, settings.seed);
    let closed = closed.map(Closed::between_runs);
    Ok(Some(Road { causes, unexplained: left - noise, noise, closed, end, dropped, model }))
}

/// The first cause of a diagnosis with the candidate that it is, if it improves held-out forecasts by more than
/// their interval; without held-out logs, if it is more probable than not.
fn accepted(
    diagnosis: &Diagnosis,
    horizon: Option<Horizon>,
    suspects: &dyn Suspects,
    known: &[Candidate],
) -> Option<(Milestone, Candidate)> {
    let cause = diagnosis.causes.first()?;
    let closed = at(diagnosis, horizon).and_then(|h| h.closed_of_refit);
    let is_better = match (closed, diagnosis.held_out.is_empty()) {
        (Some(closed), _) => 0.0 < closed.interval[0],
        (None, true) => 0.5 < 1.0 - diagnosis.no_gap - diagnosis.none_of_these,
        (None, false) => false,
    };
    let is_forbidden = diagnosis.objections.iter().any(Objection::forbids);
    if !is_better || is_forbidden {
        return None;
    }
    let offers = match known.last() {
        None => suspects.alone(),
        Some(last) => suspects.beside(last),
    };
    let is_it = |c: &Candidate| c.identity() == cause.identity() && c.law == cause.law;
    let candidate = offers.into_iter().flatten().find(is_it)?;
    let tied: Vec<&Cause> = diagnosis.tied.iter().filter_map(|id| diagnosis.cause(*id)).collect();
    // That something else is missing as well is what the road is about.
    let known = (1.0 - diagnosis.no_gap - diagnosis.none_of_these).max(f64::MIN_POSITIVE);
    let of_tied: f64 = tied.iter().map(|cause| cause.probability).sum();
    let milestone = Milestone {
        cause: cause.clone(),
        probability: (of_tied / known).min(1.0),
        tied: tied.iter().skip(1).map(|cause| cause.label.to_owned()).collect(),
        share: None,
        closed,
    };
    Some((milestone, candidate))
}

/// Whether the refitted model comes down to the noise.
fn is_noise(diagnosis: &Diagnosis) -> bool {
    diagnosis.regime == Regime::AtTheFloor && 0.5 < diagnosis.no_gap
}

/// The horizon at which forecasts judge all the way: that of the fits, if held-out logs were forecast at that, or the
/// longest one; `None` without held-out logs.
fn judged_at(diagnosis: &Diagnosis, settings: &Settings) -> Option<Horizon> {
    let mut horizons = diagnosis.held_out.iter().map(|held_out| held_out.horizon);
    let longest = diagnosis.held_out.last().map(|held_out| held_out.horizon);
    horizons.find(|horizon| *horizon == settings.horizon).or(longest)
}

/// Held-out gaps at a horizon, or at the longest one where it is not there.
fn at(diagnosis: &Diagnosis, horizon: Option<Horizon>) -> Option<&HeldOut> {
    let wanted = diagnosis.held_out.iter().find(|held_out| Some(held_out.horizon) == horizon);
    wanted.or_else(|| diagnosis.held_out.last())
}

/// A held-out gap over all outputs, in `sigma`; NaN without held-out logs.
fn total(held_out: Option<&HeldOut>, sigma: &[f64], of: fn(&HeldOut) -> &Vec<f64>) -> f64 {
    held_out.map_or(f64::NAN, |held_out| {
        let each = of(held_out).iter().zip(sigma);
        let squares: f64 = each.map(|(size, sigma)| (size / sigma).powi(2)).sum();
        (squares / sigma.len().max(1) as f64).sqrt()
    })
}
