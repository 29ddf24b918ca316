//! The colour of the noise.

use crate::together::each;

use crate::{
    diagnose::{
        prepare::noise::KnownNoise,
        search::{finish, searched::Searched, trial::Trial},
    },
    evidence::likelihood,
    fit::{FitError, Weights, null_fit},
    quality::REACHED,
    shrink::gap_per_output,
};

/// Innovation, as a fraction of the noise, below which noise is coloured.
pub(super) const COLOURED: f64 = 0.985;

/// Weights of the errors with the colour that the errors of an explanation (in sigma) have; `None`
/// where they are white. Errors far above the noise have no colour, which may be another effect, but
/// for outputs with slow noise.
pub(in crate::diagnose) fn colour_of(
    searched: &Searched<'_>,
    noise: &KnownNoise,
    errors: &[Vec<Vec<f64>>],
) -> Option<Weights> {
    let is_near = noise.reach(errors) <= REACHED;
    let mut weights = searched.null.problem.weights().clone();
    let gaps = gap_per_output(errors);
    let found = likelihood(errors, &noise.priors(true)).colour;
    for (c, found) in found.into_iter().enumerate() {
        if is_near || noise.slow[c] {
            weights.colour[c] = found;
        }
        // The size of what is slow is that of the errors themselves.
        if noise.slow[c] && weights.colour[c].innovation() < COLOURED {
            weights.sigma[c] *= gaps[c];
        }
    }
    let is_coloured = weights.colour.iter().any(|colour| colour.innovation() < COLOURED);
    is_coloured.then_some(weights)
}

/// The same search with noise of a colour: everything is fitted again, with whitened errors.
pub(in crate::diagnose) fn with_colour<'a>(
    searched: Searched<'a>,
    weights: &Weights,
    finalists: usize,
) -> Result<Searched<'a>, FitError> {
    let Searched { null: white, mut trials, mut noise, .. } = searched;
    noise.sigma.clone_from(&weights.sigma);
    let null = null_fit(white.problem.plan(), white.problem.simulator(), weights)?;
    let least = trials.iter().map(Trial::cost).fold(f64::INFINITY, f64::min);
    each(&mut trials, |trial| trial.recolour(&null, weights, least));
    finish(&mut trials, &null, finalists);
    Ok(Searched { null, trials, noise, is_coloured: true, ..searched })
}
