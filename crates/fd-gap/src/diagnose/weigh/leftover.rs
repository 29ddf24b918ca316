//! What the best explanation leaves: is it noise of the stated kind?

use super::{
    colour::COLOURED,
    known::{Known, signals},
};
use crate::{
    diagnose::{prepare::noise::KnownNoise, result::Leftover},
    evidence::{NoisePrior, likelihood},
    quality::pattern,
};

/// What the errors of an explanation (in sigma) hold beyond noise. `gaps` are those of the
/// refitted model and of the explanation, per output, and `floor` is that of the noise.
pub(super) fn leftover(
    known: Known<'_>,
    errors: &[Vec<Vec<f64>>],
    noise: &KnownNoise,
    [before, after]: [&[f64]; 2],
    floor: &[f64],
) -> Leftover {
    let priors = noise.priors(true);
    let signals = signals(known);
    let level = errors.iter().zip(&priors).map(|(errors, prior)| raised(errors, *prior)).sum();
    // Errors of rounding follow the output by themselves.
    let pattern = errors
        .iter()
        .zip(&priors)
        .filter(|(_, prior)| prior.step.is_none())
        .map(|(errors, _)| pattern(errors, &signals))
        .sum();
    let reducible = |gaps: &[f64]| -> f64 {
        gaps.iter().zip(floor).map(|(gap, floor)| (gap * gap - floor * floor).max(0.0)).sum()
    };
    let (before, after) = (reducible(before), reducible(after));
    let share = if 0.0 < before { (after / before).sqrt() } else { 0.0 };
    Leftover { level, pattern, share }
}

/// What it costs that the errors of an output are stronger than the noise should be, if they have
/// a colour as well; white ones are noise that was stated too small.
fn raised(errors: &[Vec<f64>], prior: NoisePrior) -> f64 {
    let found = likelihood(&[errors.to_vec()], &[prior]);
    let (Some(scale), Some(colour)) = (found.scale.first(), found.colour.first()) else {
        return 0.0;
    };
    let innovation = colour.innovation();
    let is_raised = prior.centre < scale.ln() && innovation < COLOURED;
    // Slow noise has few independent samples, roughly n g² of them.
    let n = errors.iter().flatten().filter(|e| e.is_finite()).count().max(1) as f64;
    let chance = 0.5 / (n * innovation * innovation);
    let spread = (chance + prior.spread.powi(2)).sqrt();
    if is_raised { NoisePrior { spread, ..prior }.cost(scale.ln()) } else { 0.0 }
}
