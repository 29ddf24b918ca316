//! The colour of the noise.

use rayon::prelude::*;

use crate::{
    diagnose::{
        prepare::noise::REACHED,
        search::{finish, searched::Searched, trial::Trial},
    },
    evidence::likelihood,
    fit::{FitError, Weights, null_fit},
};

/// Innovation, as a fraction of the noise, below which noise is coloured.
pub(super) const COLOURED: f64 = 0.985;

/// Weights of the errors with the colour that the errors of an explanation (in sigma) have; `None`
/// where they are white, or so far above the noise that their colour may be another effect.
pub(super) fn colour_of(searched: &Searched<'_>, errors: &[Vec<Vec<f64>>]) -> Option<Weights> {
    if REACHED < searched.noise.reach(errors) {
        return None;
    }
    let mut weights = searched.null.problem.weights().clone();
    weights.colour = likelihood(errors, &searched.noise.priors(true)).colour;
    let is_coloured = weights.colour.iter().any(|colour| colour.innovation() < COLOURED);
    is_coloured.then_some(weights)
}

/// The same search with noise of a colour: everything is fitted again, with whitened errors.
pub(super) fn with_colour<'a>(
    searched: Searched<'a>,
    weights: &Weights,
    finalists: usize,
) -> Result<Searched<'a>, FitError> {
    let Searched { null: white, mut trials, .. } = searched;
    let null = null_fit(white.problem.plan(), white.problem.simulator(), weights)?;
    let least = trials.iter().map(Trial::cost).fold(f64::INFINITY, f64::min);
    trials.par_iter_mut().for_each(|trial| trial.recolour(&null, weights, least));
    finish(&mut trials, &null, finalists);
    Ok(Searched { null, trials, is_coloured: true, ..searched })
}
