//! Along the road: as far as forecasts bear out far above the noise, by evidence near it.

use fd_sim::model::Model;

use super::{
    adjustable::With,
    beside::Beside,
    beyond::beyond,
    by_evidence::by_evidence,
    eliminate::Judge,
    finish::{Found, at, finish, judged_at, total},
    list::{Listed, Lists},
    result::{End, Road},
    to_the_noise::to_the_noise,
};
use crate::{
    diagnose::{Case, Diagnosis, Monitor, Regime, Settings, Verdict},
    fit::{FitError, Horizon},
};

/// How far a road may go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// Most causes.
    pub most: usize,
    /// Whether runs are dear: then there are no lists by evidence, which cost up to sixteen diagnoses.
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

/// A diagnosis, and what is needed to go on from it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Journey<'a> {
    pub(super) case: &'a Case<'a>,
    pub(super) first: &'a Diagnosis,
    pub(super) settings: &'a Settings,
    /// Most causes.
    pub(super) most: usize,
    pub(super) lists: Lists<'a>,
    /// Horizon at which forecasts judge; `None` without held-out logs.
    pub(super) horizon: Option<Horizon>,
}

impl<'a> Journey<'a> {
    /// Asks about the model with a list in it and what can be tried beside that; what is in a `fitted` model starts from
    /// there as well.
    pub(super) fn beside<R>(
        &self,
        list: &[Listed],
        fitted: Option<&Model>,
        ask: impl FnOnce(&Case<'_>) -> R,
    ) -> R {
        let nominal = With { nominal: self.case.nominal, model: self.lists.model(list).clone() };
        let suspects = Beside { fitted, ..self.lists.beside(list) };
        ask(&Case { nominal: &nominal, suspects: &suspects, ..*self.case })
    }

    /// What compares forecasts; `None` without held-out logs.
    pub(super) fn judge(&self) -> Option<Judge<'a>> {
        let Self { case, first, settings, .. } = *self;
        let (horizon, sigma) = (self.horizon?, first.sigma.as_slice());
        let floor = total(at(first, Some(horizon)), sigma, |h| &h.floor);
        Some(Judge { case, settings, horizon, sigma, floor, regime: first.regime })
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
) -> Result<Option<Road>, FitError> {
    let Bounds { most, is_dear } = bounds.into();
    if first.is_logged_loop || first.verdict == Verdict::NoGap {
        return Ok(None);
    }
    let model = case.nominal.model();
    let parameters: Vec<String> = model.parameters.iter().map(|p| p.name.clone()).collect();
    let lists = Lists { suspects: case.suspects, model, parameters: &parameters };
    let horizon = judged_at(first, settings);
    let journey = Journey { case, first, settings, most, lists, horizon };
    let found = match first.regime {
        Regime::AtTheFloor if is_dear => None,
        Regime::AtTheFloor => simulated(by_evidence(&journey, monitor))?,
        Regime::AboveTheFloor => {
            let found = simulated(beyond(&journey, monitor).map(Some))?;
            let is_open = found.as_ref().is_none_or(|found| found.end == End::NothingHelps);
            if is_open && !is_dear {
                let believed = found.as_ref().map_or(&[][..], |found| &found.list);
                simulated(to_the_noise(&journey, believed, monitor))?.or(found)
            } else {
                found
            }
        }
    };
    found
        .filter(|found: &Found| !found.list.is_empty())
        .map_or(Ok(None), |found| simulated(finish(&journey, found)))
}

/// What was found, unless a list on the way to it cannot be simulated: then there is none, and the one cause stands.
fn simulated<T>(found: Result<Option<T>, FitError>) -> Result<Option<T>, FitError> {
    match found {
        Err(FitError::Diverged) => Ok(None),
        found => found,
    }
}
