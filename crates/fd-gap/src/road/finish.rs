//! The end of a road: which causes are missed, what each takes away, and what all of them leave.

use super::{
    drive::Journey,
    eliminate::{Eliminated, Refitted},
    list::Listed,
    result::{End, Milestone, Road},
};
use crate::{
    diagnose::{Diagnosis, HeldOut, Settings},
    fit::{FitError, Horizon},
    shrink::{Closed, closed, gap},
};

/// What was found on the way.
#[derive(Debug)]
pub(super) struct Found {
    pub(super) list: Vec<Listed>,
    /// Held-out gap without any cause, and after each, in sigma; NaN where it is not known.
    pub(super) gaps: Vec<f64>,
    pub(super) end: End,
}

/// Looks back: which causes are missed, what each takes away, and what all of them leave.
pub(super) fn finish(
    journey: &Journey<'_>,
    Found { list, gaps, end }: Found,
) -> Result<Option<Road>, FitError> {
    let Journey { case, settings, lists, .. } = *journey;
    let model = lists.model(&list).clone();
    let mut causes: Vec<Milestone> = list.into_iter().map(|listed| listed.milestone).collect();
    let plain = |causes, model| {
        let (dropped, closed) = (Vec::new(), None);
        Road { causes, unexplained: f64::NAN, noise: f64::NAN, closed, end, dropped, model }
    };
    let Some(judge) = journey.judge() else { return Ok(Some(plain(causes, model))) };
    let floor = judge.floor;
    for (cause, gap) in causes.iter_mut().zip(gaps.windows(2)) {
        cause.share = Some((gap[0] - gap[1]) / gaps[0]);
    }
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

/// The horizon at which forecasts judge all the way: that of the fits, if held-out logs were forecast at that, or the
/// longest one; `None` without held-out logs.
pub(super) fn judged_at(diagnosis: &Diagnosis, settings: &Settings) -> Option<Horizon> {
    let mut horizons = diagnosis.held_out.iter().map(|held_out| held_out.horizon);
    let longest = diagnosis.held_out.last().map(|held_out| held_out.horizon);
    horizons.find(|horizon| *horizon == settings.horizon).or(longest)
}

/// Held-out gaps at a horizon, or at the longest one where it is not there.
pub(super) fn at(diagnosis: &Diagnosis, horizon: Option<Horizon>) -> Option<&HeldOut> {
    let wanted = diagnosis.held_out.iter().find(|held_out| Some(held_out.horizon) == horizon);
    wanted.or_else(|| diagnosis.held_out.last())
}

/// A held-out gap over all outputs, in `sigma`; NaN without held-out logs.
pub(super) fn total(
    held_out: Option<&HeldOut>,
    sigma: &[f64],
    of: fn(&HeldOut) -> &Vec<f64>,
) -> f64 {
    held_out.map_or(f64::NAN, |held_out| {
        let each = of(held_out).iter().zip(sigma);
        let squares: f64 = each.map(|(size, sigma)| (size / sigma).powi(2)).sum();
        (squares / sigma.len().max(1) as f64).sqrt()
    })
}
