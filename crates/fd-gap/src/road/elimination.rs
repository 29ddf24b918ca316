//! The end of a road: which causes are missed, what each takes away, and what all of them leave.

use super::{
    result::{CauseList, ListedCause},
    selection::{Found, Named, Selection},
};
use crate::{
    diagnose::{Cause, Diagnosis, EffectSet, Regime, Settings, adjustable},
    fit::{FitError, Horizon},
    shrink::{Errors, gap},
};

/// Looks back: which causes are missed, what each takes away, and what all of them leave.
pub(super) fn finish(selection: &Selection<'_>, found: Found) -> Result<CauseList, FitError> {
    let Found { set, named, end } = found;
    let (set, named) = match selection.first.regime {
        Regime::AtTheFloor => largest_first(selection, set, named),
        Regime::AboveTheFloor => (set, named),
    };
    let (set, named, dropped) = missed(selection, set, named)?;
    // With each cause, beside those before it alone.
    let mut forecasts = vec![selection.search.forecast(&selection.search.none()?)?];
    for n in 1..set.members.len() {
        let places: Vec<usize> = (0..n).collect();
        let before = selection.search.only(&set, &places);
        forecasts.push(before.map_or(Ok(None), |before| selection.search.forecast(&before))?);
    }
    forecasts.push(selection.search.forecast(&set)?);
    let sizes: Vec<f64> = forecasts.iter().map(|errors| size(errors.as_deref())).collect();
    let [before, after] = [sizes[0], sizes[sizes.len() - 1]];
    let [left, noise] = shares([before, after], selection.floor());
    let causes = set.causes();
    let model = causes.first().map(|cause| adjustable(&cause.model, &causes));
    let model = model.ok_or(FitError::Diverged)?;
    let causes = causes.into_iter().zip(named).zip(forecasts.windows(2).zip(sizes.windows(2)));
    let causes = causes.map(|((cause, named), (forecasts, sizes))| {
        let Named { log_evidence, probability, tied, odds } = named;
        let share = (sizes[0] - sizes[1]) / before;
        let share = share.is_finite().then_some(share);
        let closed = selection.closed(forecasts[0].as_deref(), forecasts[1].as_deref());
        ListedCause {
            cause: Cause { log_evidence, ..cause },
            probability,
            tied,
            share,
            closed,
            odds,
        }
    });
    let causes: Vec<ListedCause> = causes.collect();
    let [first, .., last] = forecasts.as_slice() else { return Err(FitError::Diverged) };
    Ok(CauseList {
        causes,
        unexplained: left - noise,
        noise,
        closed: selection.closed(first.as_deref(), last.as_deref()),
        end,
        dropped,
        model,
    })
}

/// Shares of a gap that are left, noise included, and that are noise; NaN where one of the gaps is not known.
fn shares([before, after]: [f64; 2], floor: f64) -> [f64; 2] {
    // `min` would take the other one.
    let at_most = |share: f64, most: f64| if share.is_nan() { share } else { share.min(most) };
    let left = at_most(after / before, 1.0);
    [left, if left.is_nan() { left } else { at_most(floor / before, left) }]
}

/// Root mean square of what a set leaves of held-out logs, in sigma; NaN without any, or where it diverges.
pub(super) fn left(selection: &Selection<'_>, set: &EffectSet) -> Result<f64, FitError> {
    Ok(size(selection.search.forecast(set)?.as_deref()))
}

fn size(errors: Option<&Errors>) -> f64 {
    errors.map_or(f64::NAN, gap)
}

/// A set in the order of the evidence of each member beside all others.
fn largest_first(
    selection: &Selection<'_>,
    set: EffectSet,
    named: Vec<Named>,
) -> (EffectSet, Vec<Named>) {
    let mut places: Vec<usize> = (0..named.len()).collect();
    places.sort_by(|a, b| named[*b].log_evidence.total_cmp(&named[*a].log_evidence));
    match selection.search.only(&set, &places) {
        Some(sorted) => (sorted, places.into_iter().map(|place| named[place].clone()).collect()),
        None => (set, named),
    }
}

/// A set without the causes that held-out forecasts do not miss, the last one excepted, which was accepted with all others
/// there; and the labels of those.
fn missed(
    selection: &Selection<'_>,
    mut set: EffectSet,
    mut named: Vec<Named>,
) -> Result<(EffectSet, Vec<Named>, Vec<String>), FitError> {
    let search = selection.search;
    let (mut dropped, mut i) = (Vec::new(), 0);
    let mut fuller = search.forecast(&set)?;
    while i + 1 < set.members.len() && fuller.is_some() {
        let plainer = search.without(&set, i);
        let forecast = match &plainer {
            Some(plainer) => search.forecast(plainer)?,
            None => None,
        };
        match plainer.filter(|_| !is_missed(selection, forecast.as_deref(), fuller.as_deref())) {
            Some(plainer) => {
                dropped.push(set.members[i].label.to_owned());
                named.remove(i);
                (set, fuller) = (plainer, forecast);
            }
            None => i += 1,
        }
    }
    Ok((set, named, dropped))
}

/// Whether held-out forecasts of the fuller model are clearly better, or, where evidence has spoken, not clearly
/// worse; where one of the two diverges, nobody knows.
fn is_missed(selection: &Selection<'_>, plainer: Option<&Errors>, fuller: Option<&Errors>) -> bool {
    let is_evident = selection.first.regime == Regime::AtTheFloor;
    if plainer.is_none() || fuller.is_none() {
        return true;
    }
    match selection.closed(plainer, fuller).map(|closed| closed.interval) {
        Some([_, high]) if is_evident => 0.0 <= high,
        Some([low, _]) => 0.0 < low,
        // Nothing is left to be shared out.
        None => is_evident,
    }
}

/// The horizon at which forecasts judge all the way: that of the fits, if held-out logs were forecast at that, or the
/// longest one; `None` without held-out logs.
pub(super) fn judged_at(diagnosis: &Diagnosis, settings: &Settings) -> Option<Horizon> {
    let mut horizons = diagnosis.held_out.iter().map(|held_out| held_out.horizon);
    let longest = diagnosis.held_out.last().map(|held_out| held_out.horizon);
    horizons.find(|horizon| *horizon == settings.horizon).or(longest)
}

#[cfg(test)]
mod tests {
    use super::shares;

    #[test]
    #[expect(clippy::float_cmp, reason = "powers of two are exact")]
    fn what_is_not_known_is_no_share() {
        assert_eq!(shares([4.0, 2.0], 1.0), [0.5, 0.25]);
        // Not more is left than there was, and not more of it is noise.
        assert_eq!(shares([4.0, 8.0], 16.0), [1.0, 1.0]);
        for unknown in [[f64::NAN, f64::NAN], [4.0, f64::NAN]] {
            assert!(shares(unknown, 1.0).iter().all(|share| share.is_nan()), "{unknown:?}");
        }
    }
}
