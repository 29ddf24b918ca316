//! The library of effects: what a simulator may lack, at every site of a model.
//!
//! An [`Effect`] offers [`Candidate`]s: patched models with parameters, their units, bounds and
//! starts. Every candidate is exactly the nominal model at zero strength, whatever its shape
//! parameters are, on the integration grid of the nominal model; strengths carry the physical
//! signs as bounds. Memories (play, lags, rate limits, hysteresis) are exact over an integration
//! step for held inputs, and what the plant sees is their mean over the step.
//!
//! Units, bounds and starts come from [`ReplayScales`], the sizes of all signals in a simulation
//! of the nominal model with the inputs of the log.

mod candidate;
mod scales;
mod sketch;

pub use self::{
    candidate::{
        Candidate, Effect, EffectParameter, Kind, NotTestable, Observation, Reason, Side, SiteRef,
    },
    scales::{ForceScale, ReplayScales, SignalScale},
    sketch::Sketch,
};

/// All effects that are known.
#[must_use]
pub fn library() -> Vec<Box<dyn Effect>> {
    Vec::new()
}
