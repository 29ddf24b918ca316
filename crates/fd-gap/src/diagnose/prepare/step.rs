//! Integration steps of models.

use fd_sim::model::Model;

/// The model with another integration step.
pub(in crate::diagnose) fn with_step(model: &Model, step: f64) -> Model {
    let mut draft = model.clone().into_draft();
    draft.step = Some(step);
    // A step does not make a correct model wrong.
    Model::try_from(draft).unwrap_or_else(|_| model.clone())
}
