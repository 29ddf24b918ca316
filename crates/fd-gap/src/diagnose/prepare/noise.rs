//! What is known of the noise, and whether errors come near it.

use crate::{
    evidence::{NoisePrior, of_rounding},
    quality::{COARSE_GRID, REACHED, noise_floor},
    shrink::gap_per_output,
};

/// Spread of `ln` of the noise where the model states it, and where it does not.
const NOISE_SPREAD: [f64; 2] = [0.1, 0.5];
/// A grid above this many times the noise is seen in it: errors of rounding are no noise of a filter.
const COARSE: f64 = 1.0;

/// What is known of the noise of each output.
#[derive(Clone, Debug)]
pub(in crate::diagnose) struct KnownNoise {
    /// What the model states, with the spread of the simulator on top, in the unit of the output.
    pub stated: Vec<Option<f64>>,
    /// Steps of grids that measured values lie on, in the unit of the output.
    pub grids: Vec<Option<f64>>,
    /// Standard deviation among equal runs of the simulator, in the unit of the output.
    pub spread: Vec<f64>,
    /// What residuals are measured in, in the unit of the output.
    pub sigma: Vec<f64>,
    /// Whether the noise of an output, which nobody states, is slow: what is left of it has a colour, and nothing
    /// that is known foretells it.
    pub slow: Vec<bool>,
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
        outputs.map(|(grid, sigma)| grid.filter(|step| COARSE_GRID * sigma < *step)).collect()
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

    /// Whether errors (in sigma) are so far above the noise that likelihoods are no use: there, forecasts are better judges.
    pub(in crate::diagnose) fn is_far(&self, errors: &[Vec<Vec<f64>>]) -> bool {
        REACHED < self.reach(errors)
    }

    /// How many times the noise is in errors (in sigma), in the output with the most; where none is
    /// stated, how many times their own floor.
    pub(in crate::diagnose) fn reach(&self, errors: &[Vec<Vec<f64>>]) -> f64 {
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
            gaps[c] / floor
        };
        (0..errors.len()).map(of).fold(0.0, f64::max)
    }
}

/// Noise that has a size after it was rounded to a grid, before that.
fn without_rounding(sigma: f64, step: f64) -> f64 {
    (sigma * sigma - of_rounding(step).powi(2)).max(0.0).sqrt()
}
