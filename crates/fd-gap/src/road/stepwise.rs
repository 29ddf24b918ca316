//! Stepwise selection of causes: as far as forecasts bear out far above the noise, by evidence near it.

use std::cell::Cell;

use super::{
    by_evidence::by_evidence,
    by_forecasts::{believed, believed_alone, grown},
    elimination::{finish, judged_at},
    result::CauseList,
    selection::Selection,
    to_the_noise::to_the_noise,
};
use crate::{
    diagnose::{Case, Cause, Diagnosis, Monitor, Regime, SetSearch, Settings, Verdict, is_law},
    fit::FitError,
};

/// Most looks beside a set on the way.
const LOOKS: usize = 32;

/// How far a road may go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// Most causes.
    pub most: usize,
    /// Whether runs are dear: then there are no lists by evidence.
    pub is_dear: bool,
}

impl From<usize> for Bounds {
    /// At most so many causes of a simulator that is cheap to run.
    ///
    /// ```
    /// use fd_gap::road::Bounds;
    ///
    /// assert_eq!(Bounds::from(8), Bounds { most: 8, is_dear: false });
    /// ```
    fn from(most: usize) -> Self {
        Self { most, is_dear: false }
    }
}

/// Goes on from a diagnosis as long as causes help and as far as the `bounds` allow. `None` where one answer is
/// all there is to say: there is no gap, one cause or one pair explains the logs down to the noise, the loop was
/// diagnosed with its controller on logged outputs, or nothing helps at all.
///
/// # Errors
///
/// As [`diagnose`](crate::diagnose::diagnose()).
pub fn road(
    case: &Case<'_>,
    first: &Diagnosis,
    settings: &Settings,
    bounds: impl Into<Bounds>,
    monitor: &dyn Monitor,
) -> Result<Option<CauseList>, FitError> {
    let Bounds { most, is_dear } = bounds.into();
    if first.is_logged_loop || first.verdict == Verdict::NoGap || is_all(case, first, is_dear) {
        return Ok(None);
    }
    let horizon = judged_at(first, settings);
    let looks = &Cell::new(LOOKS);
    let begin = |may_be_in_windows| {
        SetSearch::new(case, first, horizon, may_be_in_windows, settings, monitor).map(Some)
    };
    if first.regime == Regime::AtTheFloor {
        let Some(search) = simulated(begin(false))? else { return Ok(None) };
        let is_to_the_noise = first.verdict != Verdict::Pair;
        let selection = Selection { looks, first, search: &search, most, horizon, is_to_the_noise };
        return simulated(by_evidence(&selection));
    }
    let Some(search) = simulated(begin(true))? else { return Ok(None) };
    let selection =
        Selection { looks, first, search: &search, most, horizon, is_to_the_noise: false };
    if is_dear && believed_alone(&selection).is_none() {
        return Ok(None);
    }
    let Some(grown) = simulated(grown(&selection))? else { return Ok(None) };
    if !is_dear {
        // What explains everything does so from the beginning of the log to its end.
        let free = if search.is_in_windows { simulated(begin(false))? } else { None };
        let set = grown.set().and_then(|set| match &free {
            Some(free) => free.of_causes(&set.causes()),
            None => Some(set.clone()),
        });
        let search = free.as_ref().unwrap_or(&search);
        let selection = Selection { search, is_to_the_noise: true, ..selection };
        let explained = match set {
            Some(set) => simulated(to_the_noise(&selection, set))?,
            None => None,
        };
        if explained.is_some() {
            return Ok(explained);
        }
    }
    match believed(&selection, &grown) {
        Some(found) => simulated(finish(&selection, found).map(Some)),
        None => Ok(None),
    }
}

/// Whether near the noise what was found is all there is to say.
fn is_all(case: &Case<'_>, first: &Diagnosis, is_dear: bool) -> bool {
    let is_single = matches!(first.verdict, Verdict::Cause | Verdict::Tied);
    let is_explained = is_single && !first.is_unexplained;
    let is_law = |cause: &Cause| is_law(case, cause);
    first.regime == Regime::AtTheFloor
        && (is_dear || is_explained && first.causes.first().is_none_or(is_law))
}

/// What was found, unless a list on the way to it cannot be simulated: then there is none, and the one cause stands.
fn simulated<T>(found: Result<Option<T>, FitError>) -> Result<Option<T>, FitError> {
    match found {
        Err(FitError::Diverged) => Ok(None),
        found => found,
    }
}
