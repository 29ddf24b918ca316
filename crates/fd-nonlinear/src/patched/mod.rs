//! Measured minus simulated output of a model with the known cause of its bias built in; its strength is
//! tracked.
//!
//! * **Equations.** `r = y − ŷ(θ₀) − Ψ a`, with `ŷ` the simulation from the inputs alone, `Ψ = ∂ŷ/∂θ` by
//!   simulations beside it, each with one parameter shifted, and `a` the distance that the named parameters
//!   have gone since. They follow a random walk, `a(k+1) = a(k) + w`, and are estimated by the Kalman filter of
//!   that walk from `r` (Ljung 1999, *System Identification*, eq. 11.65 to 11.67), output by output.
//! * **Frozen while a fault is suspected**: the estimate rests, and its covariance with it, as long as the
//!   smoothed residual is outside of what healthy logs showed. Wear is slow and goes along `Ψ`; a fault is what
//!   neither explains. What is slower than the walk allows, and looks like wear, is taken for wear.
//! * **Assumptions.** The plant is stable, so that its start is forgotten; the cause is the right one, see
//!   `fd-gap`, which finds it and writes the model; parameters stay where `Ψ a` is nearly linear: of a change
//!   of a tenth some per cent are missed, of a change of a rate constant by a quarter a fifth. After larger
//!   changes diagnose and patch again.
//! * **Do not use** it for a bias whose cause is unknown: that is what bias models are for. They also take what
//!   this one leaves. Do not track a parameter that a fault would change: the fault would be followed.

mod design;
mod learn;
mod run;
mod track;
mod tracking;

pub use self::{
    design::PatchedDesign,
    run::Patched,
    tracking::{Tracked, Tracking},
};
