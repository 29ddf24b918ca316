//! Far above the noise: one cause after another, as long as they are believed together.

use super::{
    drive::Journey,
    finish::{Found, at, total},
    list::Listed,
    milestone::milestone,
    result::End,
};
use crate::{
    diagnose::{
        Diagnosis, HeldOut, Monitor, Objection, Regime, Verdict, diagnose, follows_anything,
    },
    fit::FitError,
};

/// Causes as long as the list with them is more probable than not and leaves less of held-out logs.
pub(super) fn beyond(journey: &Journey<'_>, monitor: &dyn Monitor) -> Result<Found, FitError> {
    let Journey { first, settings, most, horizon, .. } = *journey;
    let sized = |diagnosis: &Diagnosis, of: fn(&HeldOut) -> &Vec<f64>| {
        total(at(diagnosis, horizon), &first.sigma, of)
    };
    let mut list: Vec<Listed> = Vec::new();
    let mut gaps = vec![sized(first, |h| &h.refit)];
    let one = settings.for_one_law();
    let mut diagnosis = first.clone();
    let end = loop {
        if list.len() == most {
            break End::Enough;
        }
        let Some(next) = accepted(journey, &diagnosis, &list) else {
            break if is_noise(&diagnosis) { End::AtTheNoise } else { End::NothingHelps };
        };
        let left = sized(&diagnosis, |h| &h.after);
        if !list.is_empty() && gaps.last().is_some_and(|before| *before <= left) {
            break End::NothingHelps;
        }
        gaps.push(left);
        list.push(next);
        diagnosis = journey.beside(&list, None, |case| diagnose(case, &one, monitor))?;
        if diagnosis.verdict == Verdict::NoGap {
            break End::AtTheNoise;
        }
        if diagnosis.is_stopped {
            break End::NothingHelps;
        }
    };
    Ok(Found { list, gaps, end })
}

/// The first cause of a diagnosis, if it is a law and the list with it is more probable than not.
fn accepted(journey: &Journey<'_>, diagnosis: &Diagnosis, list: &[Listed]) -> Option<Listed> {
    let cause = diagnosis.causes.first()?;
    let is_forbidden = diagnosis.objections.iter().any(Objection::forbids);
    let before: f64 = list.iter().map(|listed| listed.milestone.cause.probability).product();
    if is_forbidden || before * cause.probability <= 0.5 {
        return None;
    }
    let listed = journey.lists.listed(list, milestone(diagnosis, cause, journey.horizon))?;
    (!follows_anything(&listed.candidate)).then_some(listed)
}

/// Whether the refitted model comes down to the noise.
fn is_noise(diagnosis: &Diagnosis) -> bool {
    diagnosis.regime == Regime::AtTheFloor && 0.5 < diagnosis.no_gap
}
