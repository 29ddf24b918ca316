//! Design-time analysis: what a residual detects, how well, and what could be detected at all.
//!
//! | Question | Answer | Source |
//! |----------|--------|--------|
//! | Does fault i reach the residual? | [`fault_effects`] | Patton and Chen 1992, eq. 6 |
//! | How far above the noise? | [`fault_to_noise_gap`] | Varga 2017, section 3.3: `J₂ = min_j ‖R_f,j‖∞ / ‖R_w‖∞` |
//! | Which residual reacts to which fault? | [`weak_structure`], [`strong_structure`] | Varga 2017, section 3.4 |
//! | Which signatures are achievable, at which order, how certainly? | [`achievable_signatures`], [`SignatureSearch`] | parity spaces of Chow and Willsky 1984 |
//!
//! The first three look at a [`ResidualForm`](crate::ResidualForm), whatever its method, in
//! discrete or continuous time. The last looks at the plant alone.
//!
//! Zero is distinguished from small by what a perturbation of all the data could do ([`rank`](crate::rank)), in
//! natural units: a fault that shows in the outputs only through rounding errors of a cancellation does not
//! count as detectable.
//!
//! **Do not use** them as a verdict on a real plant: they know the nominal model only. Nor with the default
//! tolerance, which is that of exact numbers, for a model that was identified: give [`SignatureSearch`] the
//! digits that the model has, and look at the margin of the nearest decision.

mod effects;
mod signature;
mod signatures;
mod structure;
mod unknown;

pub use self::{
    effects::{FaultEffect, Gap, fault_effects, fault_to_noise_gap},
    signature::Signature,
    signatures::{Achievable, SignatureSearch, Signatures, achievable_signatures},
    structure::{strong_structure, weak_structure},
    unknown::UnknownInputs,
};
