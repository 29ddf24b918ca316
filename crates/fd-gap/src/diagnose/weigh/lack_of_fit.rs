//! How much of the gap an answer leaves, and how much of that may be noise.

use super::{answer::Answer, known::Known, leftover::leftover};
use crate::{
    diagnose::{prepare::noise::KnownNoise, result::Leftover},
    fit::Problem,
    quality::{AT_THE_NOISE, noise_floor},
    shrink::gap_per_output,
};

/// What is left of the gap, and how much of that may be noise.
#[derive(Clone, Debug)]
pub(in crate::diagnose) struct LackOfFit {
    /// Noise floor of each output, in sigma.
    pub floor: Vec<f64>,
    /// Whether some output is clearly above it.
    pub is_unexplained: bool,
    pub leftover: Leftover,
}

/// What an answer leaves of the gap of the `refit`ted model, of which `base` is the problem.
pub(super) fn lack_of_fit(
    answer: &Answer,
    refit: &Answer,
    base: &Problem,
    noise: &KnownNoise,
    is_coloured: bool,
) -> LackOfFit {
    let gaps = gap_per_output(&answer.errors);
    let floor: Vec<f64> = (0..gaps.len())
        .map(|c| {
            let stated = noise.expected(c);
            let floor = noise_floor(&answer.errors[c].join(&f64::NAN), stated).unwrap_or(1.0);
            let floor = floor.max(noise.at_least(c));
            // Slow noise of the stated size is noise, whatever its innovation; where none is stated, of any size.
            let largest = if noise.slow[c] { Some(f64::INFINITY) } else { stated };
            let slow = largest.filter(|_| is_coloured).map(|largest| gaps[c].min(largest));
            slow.map_or(floor, |slow| floor.max(slow))
        })
        .collect();
    let is_unexplained = gaps.iter().zip(&floor).any(|(gap, f)| AT_THE_NOISE * f < *gap);
    let outputs = &answer.explanation.outputs;
    // A controller on logged outputs has these for inputs as well, with their noise.
    let inputs = refit.explanation.model.external_inputs().len();
    let known = Known { problem: base, inputs, outputs };
    let before_and_after = [refit.explanation.gap.as_slice(), gaps.as_slice()];
    let leftover = leftover(known, &answer.errors, noise, before_and_after, &floor);
    LackOfFit { floor, is_unexplained, leftover }
}
