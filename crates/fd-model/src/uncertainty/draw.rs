//! Random stable models, drawn until one is stable.

use crate::{domain::TimeDomain, error::ModelError, state_space::StateSpace};

/// A random stable model.
#[derive(Clone, Debug)]
pub struct Draw<D> {
    /// Perturbed model; all its modes decay.
    pub model: StateSpace<D>,
    /// Models that were thrown away before because they were unstable. Many of them mean that
    /// the drawn models are no fair sample of the perturbation.
    pub rejected: usize,
}

/// Draws that may be unstable before giving up.
const LIMIT: usize = 1000;

/// Repeats a draw until its model is stable; gives back what came with it.
pub(super) fn until_stable<D: TimeDomain, E>(
    nominal: &StateSpace<D>,
    mut draw: impl FnMut() -> Result<(StateSpace<D>, E), ModelError>,
) -> Result<(Draw<D>, E), ModelError> {
    nominal.stable_poles("a perturbed nominal model")?;
    for rejected in 0..LIMIT {
        let (model, extra) = draw()?;
        if model.is_stable()? {
            return Ok((Draw { model, rejected }, extra));
        }
    }
    Err(ModelError::NoStableDraw { draws: LIMIT })
}

/// Checks the relative size of a perturbation.
pub(super) fn check_fraction(fraction: f64) -> Result<(), ModelError> {
    if (0.0..f64::INFINITY).contains(&fraction) {
        Ok(())
    } else {
        let (role, range) = ("the relative size of a perturbation", "[0, ∞)");
        Err(ModelError::OutOfRange { role, range, value: fraction })
    }
}
