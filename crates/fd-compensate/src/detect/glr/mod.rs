//! The generalised likelihood ratio: a change of unknown size at an unknown time (Willsky & Jones 1976).
//!
//! A fault that began `t + 1` samples ago adds `F(0) θ, …, F(t) θ` to the whitened residual `e`, with known
//! course `F` and unknown size `θ`. With `e` white, of unit variance, twice the logarithm of the likelihood
//! ratio against no fault, at the most likely size, is
//!
//! ```text
//! l(k, t) = cᵀ J⁻¹ c,   c = Σ_{i=0…t} F(i)ᵀ e(k−t+i),   J = Σ_{i=0…t} F(i)ᵀ F(i),   θ̂ = J⁻¹ c
//! g(k)    = max over courses and over t < window of l(k, t)
//! ```
//!
//! (Basseville & Nikiforov 1993, section 7.2.4). The courses are those of [steps or ramps](Course) as the
//! [whitening filter](super::whiten) leaves them, along each given signature (one unknown size) or in any
//! direction at all (as many unknown sizes as channels).
//!
//! For each of the last `window` onsets the sum `c` is carried on, so one sample costs
//! `window · channels · sizes` operations, whatever the window, and nothing is summed twice.
//!
//! **Assumptions.** Gaussian residual, white after the filter; one fault at a time; a fault older than the
//! window is seen as one that began with it. `2 ln Λ` of one onset is chi-square distributed with as many
//! degrees of freedom as sizes, but the maximum over dependent onsets has no closed form: calibrate, or take
//! [`run_length`](crate::evaluate::run_length).
//!
//! **Not to be used** with channels that depend on each other linearly, nor where nothing is known of the
//! fault's course and the residual is strongly coloured: a step in a filtered residual fades.

mod design;
mod run;

pub use self::{
    design::{Course, GlrDesign},
    run::{Change, Glr},
};
