//! Causes that forecasts do not miss.

use fd_sim::model::Model;

use super::{
    adjustable::{With, without},
    result::Milestone,
};
use crate::{
    diagnose::{Case, FittedValues, Regime, Settings, prepare, settle},
    fit::{FitError, Horizon, Log},
    shrink::{as_begun, closed, forecast_errors, gap},
};

/// The models that are compared, and how.
#[derive(Clone, Copy, Debug)]
pub(super) struct Judge<'a> {
    pub(super) case: &'a Case<'a>,
    pub(super) settings: &'a Settings,
    /// Horizon of the forecasts.
    pub(super) horizon: Horizon,
    /// Noise of each output, in its unit.
    pub(super) sigma: &'a [f64],
    /// Noise floor, in sigma.
    pub(super) floor: f64,
    /// What the causes were found by: what evidence has found beside all others only loses by forecasts that contradict it.
    pub(super) regime: Regime,
}

impl Judge<'_> {
    /// Takes out causes, the last one excepted, that the rest does not miss.
    pub(super) fn eliminate(
        &self,
        mut model: Model,
        causes: &mut Vec<Milestone>,
    ) -> Result<Eliminated, FitError> {
        let mut refitted = self.refitted(&model)?;
        let mut dropped = Vec::new();
        let mut i = 0;
        // The last one was accepted with all others there.
        while i + 1 < causes.len() {
            let plainer = without(&model, &causes[i].cause);
            let without_it = self.refitted(&plainer)?;
            if self.is_missed(without_it.as_ref(), refitted.as_ref()) {
                i += 1;
            } else {
                dropped.push(causes.remove(i).cause.label.to_owned());
                (model, refitted) = (plainer, without_it);
            }
        }
        Ok(Eliminated { model, refitted, dropped })
    }

    /// Whether held-out forecasts of the fuller model are clearly better, or, where evidence has spoken, not clearly
    /// worse; where one of the two diverges, nobody knows.
    pub(super) fn is_missed(&self, plainer: Option<&Refitted>, fuller: Option<&Refitted>) -> bool {
        let (Some(before), Some(after)) = (plainer, fuller) else { return true };
        let Settings { replicas, seed, .. } = *self.settings;
        let share = closed(&before.errors, &after.errors, self.floor, replicas, seed);
        let [low, high] = match share {
            Some(share) => share.between_runs().interval,
            // Nothing is left to be shared out.
            None => return self.regime == Regime::AtTheFloor,
        };
        match self.regime {
            Regime::AtTheFloor => 0.0 <= high,
            Regime::AboveTheFloor => 0.0 < low,
        }
    }

    /// What a refitted model leaves of held-out logs, root mean square, in sigma; NaN when it diverges.
    pub(super) fn left(&self, model: &Model) -> Result<f64, FitError> {
        Ok(self.refitted(model)?.map_or(f64::NAN, |refitted| gap(&refitted.errors)))
    }

    /// Refits a model and forecasts with it; `None` when it diverges.
    pub(super) fn refitted(&self, model: &Model) -> Result<Option<Refitted>, FitError> {
        let nominal = With { nominal: self.case.nominal, model: model.clone() };
        let case = Case { nominal: &nominal, ..*self.case };
        let prepared = prepare(&case, self.settings.horizon)?;
        let (problem, at) = (&prepared.null.problem, &prepared.null.minimum);
        let logs = Log::held_out(case.held_out, problem.simulator(), case.logs, problem.plan())?;
        let values = FittedValues::of(problem, at);
        let simulator = problem.simulator();
        let logs = as_begun(simulator, values.settled(), logs, self.sigma)?;
        let errors = forecast_errors(simulator, values.settled(), &logs, self.horizon, self.sigma)?;
        Ok(errors.map(|errors| Refitted { errors, model: settle(model, problem, &at.z) }))
    }
}

/// What is left when causes that forecasts do not miss are out.
#[derive(Debug)]
pub(super) struct Eliminated {
    pub(super) model: Model,
    /// That model, refitted; `None` when it diverges.
    pub(super) refitted: Option<Refitted>,
    /// Labels of what was dropped.
    pub(super) dropped: Vec<String>,
}

/// A model with its parameters refitted.
#[derive(Debug)]
pub(super) struct Refitted {
    /// Of held-out forecasts, in sigma.
    pub(super) errors: Vec<Vec<Vec<f64>>>,
    pub(super) model: Model,
}
