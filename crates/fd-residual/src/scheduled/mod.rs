//! An observer whose model and gain follow an operating variable.
//!
//! * **Equation.** At grid points `ρ_i` there are linear models about steady states `(x₀, u₀, y₀)_i` with observer gains
//!   `L_i`. Between two of them all of these are interpolated linearly, with the same weight:
//!   `x̂⁺ = x₀(ρ) + A(ρ) (x̂ − x₀(ρ)) + B(ρ) (u − u₀(ρ)) + L(ρ) r`, `r = y − y₀(ρ) − C(ρ) (x̂ − x₀(ρ)) − D(ρ) (u − u₀(ρ))`.
//!   There is one state, in absolute coordinates, and all that multiplies it is continuous in `ρ`: passing a grid point
//!   makes no bump. Outside of the grid its ends hold.
//! * **Stability** is checked at the grid points and between them. That makes slow changes of `ρ` safe; for changes of any
//!   speed a common `P > 0` with `F(ρ)ᵀ P F(ρ) < P`, `F = A − L C`, is looked for, and [`ScheduledDesign::any_speed`] says
//!   whether one was found.
//! * **Source.** W. J. Rugh and J. S. Shamma, "Research on gain scheduling", Automatica 36(10), 2000; for residuals:
//!   J. Bokor and G. Balas, "Detection filter design for LPV systems", Automatica 40(3), 2004.
//! * **Assumptions.** The models of all points have the same states with the same meaning (linearisations of one plant, not
//!   identified one by one), and `ρ` changes slowly next to the plant; the variable is a measured channel.
//! * **Do not use** it where an equation model exists: a filter on it
//!   (`fd-nonlinear`) has no grid. Nor with an output as the variable when that sensor may fail, unless the others show it:
//!   the fault moves the model. For models from which no variable tells, take [`model_detection`](crate::model_detection).

mod design;
mod grid;
mod run;
mod stability;

pub use self::{
    design::ScheduledDesign,
    grid::{ScheduledPoint, SchedulingVariable},
    run::ScheduledObserver,
};
