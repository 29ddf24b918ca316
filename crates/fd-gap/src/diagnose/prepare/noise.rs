//! What is known of the noise, and whether errors come near it.

use crate::{
    evidence::{NoisePrior, of_rounding},
    quality::noise_floor,
    shrink::gap_per_output,
};

/// Spread of `ln` of the noise where the model states it, and where it does not.
const NOISE_SPREAD: [f64; 2] = [0.1, 0.5];
/// A grid above this many times the noise is seen in it: errors of rounding are no noise of a filter.
const COARSE: f64 = 1.0;
/// A grid above this many times the noise is a property of the log that is worth telling, not of the file's digits.
const SEEN: f64 = 0.5;
/// Times the stated noise that the best explanation leaves from which likelihoods are no use.
const FAR: f64 = 5.0;
/// Errors within this many times the noise may be noise of another colour.
pub(in crate::diagnose) const REACHED: f64 = 2.0;

/// What is known of the noise of each output.
#[derive(Clone, Debug)]
pub(in crate::diagnose) struct KnownNoise {
    /// What the model states, with the spread of the simulator on top, in the unit of the output.
    pub(in crate::diagnose) stated: Vec<Option<f64>>,
    /// Steps of grids that measured values lie on, in the unit of the output.
    pub(in crate::diagnose) grids: Vec<Option<f64>>,
    /// Standard deviation among equal runs of the simulator, in the unit of the output.
    pub(in crate::diagnose) spread: Vec<f64>,
    /// What residuals are measured in, in the unit of the output.
    pub(in crate::diagnose) sigma: Vec<f64>,
    /// Whether the noise of an output, which nobody states, is slow: what is left of it has a colour, and nothing
    /// that is known foretells it.
    pub(in crate::diagnose) slow: Vec<bool>,
}

impl KnownNoise {
    /// The noise of each output as an unknown, in units of sigma.
    pub(in crate::diagnose) fn priors(&self, is_coloured: bool) -> Vec<NoisePrior> {
        let of = |c: usize| {
            let (stated, sigma) = (self.stated[c], self.sigma[c]);
            let white = NoisePrior::white(NOISE_SPREAD[usize::from(stated.is_none())]);
            let prior = if let Some(step) = self.grids[c].filter(|_| self.is_coarse(c)) {
                let before = stated.unwrap_or_else(|| without_rounding(sigma, step));
                white.rounded(before / sigma, step / sigma)
            } else {
                let centre = stated.map_or(0.0, |stated| (stated / sigma).ln());
                NoisePrior { centre, ..white }
            };
            prior.coloured(is_coloured)
        };
        (0..self.sigma.len()).map(of).collect()
    }

    /// Whether an output lies on a grid that is coarse beside its noise.
    pub(in crate::diagnose) fn is_coarse(&self, output: usize) -> bool {
        self.grids[output].is_some_and(|step| COARSE * self.sigma[output] < step)
    }

    /// The grids whose steps are seen in the noise, in the unit of the output.
    pub(in crate::diagnose) fn steps(&self) -> Vec<Option<f64>> {
        let outputs = self.grids.iter().zip(&self.sigma);
        outputs.map(|(grid, sigma)| grid.filter(|step| SEEN * sigma < *step)).collect()
    }

    /// What errors are at least, in sigma: a log in steps of `q` has errors of `q/√12`, however smooth it looks, and
    /// a simulator that does not repeat itself has its spread.
    pub(in crate::diagnose) fn at_least(&self, output: usize) -> f64 {
        let rounding = self.grids[output].map_or(0.0, of_rounding);
        rounding.hypot(self.spread[output]) / self.sigma[output]
    }

    /// The size of the noise that the model states of an output, in sigma, after values are rounded as they are.
    pub(in crate::diagnose) fn expected(&self, output: usize) -> Option<f64> {
        let step = self.grids[output].filter(|_| self.is_coarse(output));
        let rounding = step.map_or(0.0, of_rounding);
        self.stated[output].map(|stated| stated.hypot(rounding) / self.sigma[output])
    }

    /// How many times the noise is in errors (in sigma), in the output with the most; where none is
    /// stated, how many times their own floor.
    pub(in crate::diagnose) fn reach(&self, errors: &[Vec<Vec<f64>>]) -> f64 {
        self.reaches(errors).into_iter().map(|reach| reach.times).fold(0.0, f64::max)
    }

    /// Whether errors (in sigma) are so far above the noise that likelihoods are no use. Nobody
    /// promises that there is noise as small as an estimated floor, and to reach it nearly is no
    /// success: there, forecasts are better judges.
    pub(in crate::diagnose) fn is_far(&self, errors: &[Vec<Vec<f64>>]) -> bool {
        1.0 < self.farness(errors)
    }

    /// How many times as far above the noise errors (in sigma) are as likelihoods are of use, in the output with the most.
    pub(in crate::diagnose) fn farness(&self, errors: &[Vec<Vec<f64>>]) -> f64 {
        let limit = |is_stated| if is_stated { FAR } else { REACHED };
        let reaches = self.reaches(errors).into_iter();
        reaches.map(|reach| reach.times / limit(reach.is_stated)).fold(0.0, f64::max)
    }

    /// As [`reach`](Self::reach), per output.
    fn reaches(&self, errors: &[Vec<Vec<f64>>]) -> Vec<Reach> {
        let gaps = gap_per_output(errors);
        let of = |c: usize| {
            let expected = self.expected(c);
            let floor = if let Some(expected) = expected {
                expected.max(1.0)
            } else if self.slow[c] {
                gaps[c].max(f64::MIN_POSITIVE)
            } else {
                let found = noise_floor(&errors[c].join(&f64::NAN), None).unwrap_or(1.0);
                found.max(self.at_least(c))
            };
            Reach { times: gaps[c] / floor, is_stated: expected.is_some() }
        };
        (0..errors.len()).map(of).collect()
    }
}

/// Noise that has a size after it was rounded to a grid, before that.
fn without_rounding(sigma: f64, step: f64) -> f64 {
    (sigma * sigma - of_rounding(step).powi(2)).max(0.0).sqrt()
}

/// How far above the noise the errors of an output are.
#[derive(Clone, Copy, Debug)]
struct Reach {
    /// Root mean square of the errors, in multiples of the noise.
    times: f64,
    /// Whether that noise is stated by the model, or estimated from the errors.
    is_stated: bool,
}
