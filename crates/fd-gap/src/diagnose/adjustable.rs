//! Models with causes in them that can still be adjusted.

use fd_sim::model::Model;

use super::result::Cause;

/// Tolerance of what was found, in standard errors …
const ERRORS: f64 = 3.0;
/// … and at most so much of its value: a sign is not lost.
const MOST: f64 = 0.5;

/// A model with what was found of the causes in it open to adjustment, so that a study of it goes on from there. What is
/// known of all else stays as it is.
///
/// ```
/// use fd_gap::diagnose::adjustable;
/// use fd_sim::model::Model;
///
/// let model: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "lag"
/// sample_time = 0.1
/// inputs = { u = { unit = "V" } }
/// outputs = { y = { unit = "V", value = "x" } }
/// parameters = { T = { unit = "s", value = 1.0, tolerance = 0.05 } }
/// states = { x = { unit = "V", initial = 0.0, derivative = "(u - x)/T" } }
/// "#.parse()?;
/// assert_eq!(adjustable(&model, []), model);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn adjustable<'a>(model: &Model, causes: impl IntoIterator<Item = &'a Cause>) -> Model {
    let mut draft = model.clone().into_draft();
    for found in causes.into_iter().flat_map(|cause| &cause.parameters) {
        let tolerance = (ERRORS * found.standard_error / found.value).abs().min(MOST);
        let of_model = draft.parameters.iter_mut().find(|p| p.name == found.name);
        if let Some(parameter) = of_model.filter(|_| tolerance.is_finite()) {
            parameter.tolerance = tolerance;
        }
    }
    // Tolerances alone make no model wrong.
    Model::try_from(draft).unwrap_or_else(|_| model.clone())
}
