//! The noise floor as it is reported: what no model could take away.
//!
//! While causes are sought, the floor has to be a lower bound ([`noise_floor`](crate::quality::noise_floor),
//! the least of two estimates), or a remaining cause would be taken for noise. As a figure to measure a
//! gap from, that is a little too low, and makes causes that explain everything seem to leave something.
//!
//! *When not to use:* to ask whether anything is left; that is the business of
//! [`LackOfFit`].

use crate::{
    diagnose::{
        prepare::noise::KnownNoise,
        weigh::{answer::Answer, lack_of_fit::LackOfFit},
    },
    quality::Autoregression,
    shrink::gap_per_output,
};

/// Slow noise is believed up to so many spreads of what is known of its size.
const BELIEVED: f64 = 2.0;

/// The floor of each output, in sigma, with the best answer known.
///
/// Where what is left is white, it is the noise: its root mean square, for the unknowns that were fitted
/// to it. Slow noise may be as strong as what is known of it allows. Elsewhere the lower bound stays.
pub(super) fn reported_floor(
    best: &Answer,
    lack_of_fit: &LackOfFit,
    noise: &KnownNoise,
    is_coloured: bool,
) -> Vec<f64> {
    let unknowns = best.fit.as_ref().map_or(0, |fit| fit.minimum.z.len());
    let outputs = best.errors.len().max(1);
    let (priors, gaps) = (noise.priors(is_coloured), gap_per_output(&best.errors));
    let of = |(c, errors): (usize, &Vec<Vec<f64>>)| {
        let (gap, floor) = (gaps[c], lack_of_fit.floor[c]);
        let signals: Vec<&[f64]> = errors.iter().map(Vec::as_slice).collect();
        let count = errors.iter().flatten().filter(|e| e.is_finite()).count() as f64;
        let free = (1.0 - unknowns as f64 / (outputs as f64 * count).max(1.0)).max(0.5);
        if is_coloured && noise.stated[c].is_some() {
            let prior = priors[c];
            floor.max(gap.min((prior.centre + BELIEVED * prior.spread).exp()))
        } else if Autoregression::fit(&signals, Autoregression::HIGHEST_ORDER).order() == 0 {
            floor.max(gap / free.sqrt())
        } else {
            floor
        }
    };
    best.errors.iter().enumerate().map(of).collect()
}

/// A floor in a closed loop: noise goes round it, by the factor by which what is left of a controller on
/// logged outputs (`logged`) has grown with the loop closed (`closed`).
pub(super) fn around_the_loop(floor: &mut [f64], logged: &[f64], closed: &[f64]) {
    for ((floor, logged), closed) in floor.iter_mut().zip(logged).zip(closed) {
        if 0.0 < *logged {
            *floor *= (closed / logged).max(1.0);
        }
    }
}
