//! Splicing an effect into a model, so that the result is again a model: it prints, loads and
//! runs like one that was written by hand.
//!
//! A [`Patch`] is one effect at one site. What it adds (parameters, states, definitions, forces)
//! sees inputs, parameters and states as they were; only what was in the model before sees the
//! wrapped ones. Two effects are two patches, one after the other: the second one on the same
//! input acts before the first, on the value that the first one receives.
//!
//! **Identity.** A patch changes nothing but the expressions it names. When its strength is zero,
//! so that the wrapping expression has the value of what it wraps and a force is zero, every
//! value of a simulation is equal to that of the unpatched model (`==`; a zero may change its
//! sign), because `x + 0` and `1*x` are exact, as long as both use the same integration step. A
//! fast state of the effect makes the simulator choose a shorter one; [`Patch::pin_step`] prevents
//! that.

mod error;
mod ports;
mod splice;

pub(crate) use self::ports::open_ports;
pub use self::{error::PatchError, splice::Patch};
