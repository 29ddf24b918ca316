//! Models with causes in them that can still be adjusted.

use fd_effect::Candidate;
use fd_model::SampleTime;
use fd_sim::{
    model::{Model, Parameter},
    simulate::{Nominal, SimulateError, Simulator},
};

use crate::diagnose::Cause;

/// Tolerance of what was found, in standard errors …
const ERRORS: f64 = 3.0;
/// … and at least so much of its value: with another cause beside it, it may be another one.
const LEAST: f64 = 0.3;
/// At most so much: a sign is not lost.
const MOST: f64 = 0.5;

/// A simulator that has another model in the place of its own.
#[derive(Debug)]
pub(super) struct With<'a> {
    pub(super) nominal: &'a dyn Nominal,
    pub(super) model: Model,
}

impl Nominal for With<'_> {
    fn model(&self) -> &Model {
        &self.model
    }

    fn patched(&self, model: &Model, ts: SampleTime) -> Result<Box<dyn Simulator>, SimulateError> {
        self.nominal.patched(model, ts)
    }
}

/// The model of a candidate, as a nominal model that knows its parameters only so well as they were found for a `cause`.
/// What is known of all other parameters and initial states stays as it is: a fit after a fit must not wander off.
pub(super) fn adjustable(candidate: &Candidate, cause: &Cause) -> Model {
    let mut draft = candidate.model.clone().into_draft();
    // Steps only become shorter.
    draft.step = cause.model.step.or(draft.step);
    for (own, found) in candidate.parameters.iter().zip(&cause.parameters) {
        let Some(parameter) = draft.parameters.iter_mut().find(|p| p.name == own.name) else {
            continue;
        };
        let relative = (ERRORS * found.standard_error / found.value).abs();
        let tolerance = if relative.is_finite() { relative } else { MOST };
        parameter.value = found.value;
        parameter.tolerance = tolerance.clamp(LEAST, MOST);
    }
    Model::try_from(draft).unwrap_or_else(|_| candidate.model.clone())
}

/// The model without one of the causes in it: its strengths are zero, and nothing of it is adjustable.
pub(super) fn without(model: &Model, cause: &Cause) -> Model {
    let mut draft = model.clone().into_draft();
    for parameter in &mut draft.parameters {
        let Some(found) = cause.parameters.iter().find(|p| p.name == parameter.name) else {
            continue;
        };
        let Parameter { value, bounds, .. } = parameter;
        if found.is_strength {
            *value = 0.0;
            *bounds = bounds.map(|[low, high]| [low.min(0.0), high.max(0.0)]);
        }
        parameter.tolerance = 0.0;
    }
    Model::try_from(draft).unwrap_or_else(|_| model.clone())
}
