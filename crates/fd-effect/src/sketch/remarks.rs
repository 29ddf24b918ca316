//! What else there is to say of a candidate.

use super::Sketch;
use crate::{
    candidate::{InAnotherRun, Kind, Observation, Rounding},
    site::SiteRef,
};

impl Sketch<'_> {
    /// Says what becomes of all strengths in another run of the plant.
    #[must_use]
    pub fn in_another_run(mut self, what: InAnotherRun) -> Self {
        for strength in self.candidate.parameters.iter_mut().filter(|p| p.is_strength) {
            strength.in_another_run = what;
        }
        self
    }

    /// Names the other end of a coupling.
    #[must_use]
    pub fn partner(mut self, site: SiteRef) -> Self {
        self.candidate.partner = Some(site);
        self
    }

    /// Names the parameter that is a frequency to be started from the residual, by its place.
    #[must_use]
    pub fn spectral(mut self, index: usize) -> Self {
        self.candidate.spectral = Some(index);
        self
    }

    /// Says that the first parameter is a quantum that the input is rounded to, with the largest
    /// input for its scale.
    #[must_use]
    pub fn rounding(mut self, rounding: Rounding) -> Self {
        self.candidate.rounding = Some(rounding);
        self
    }

    /// Says that the effect is one of the distribution of a measurement: nothing is patched.
    #[must_use]
    pub fn observation(mut self, kind: Observation) -> Self {
        self.candidate.kind = Kind::Observation(kind);
        self
    }
}
