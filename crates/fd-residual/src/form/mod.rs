//! The general form `r = H_u(z) u + H_y(z) y` of every residual generator.
//!
//! * **Equation.** `r(z) = H_u(z) u(z) + H_y(z) y(z)` (Patton and Chen 1992, eq. 2), with
//!   `H_u(z) + H_y(z) G_u(z) = 0` (eq. 5), so that `r = 0` for a plant `y = G_u u` without faults
//!   (eq. 3, 4), and `r = H_y G_f f` with them (eq. 6).
//! * **Realisation.** One [`StateSpace`](fd_model::StateSpace) with input `[u; y]` and output `r`,
//!   so `H_u` and `H_y` share their states.
//! * **Assumptions.** Linear and time-invariant. [`FormGenerator`] runs any stable discrete form,
//!   for example one that was published or designed elsewhere.
//! * **Do not use** [`FormGenerator`] for the rooms of this crate: their own run-time types need
//!   fewer operations, and a parity window holds its residual at zero until it is full.

mod design;
mod frequency;
mod part;
mod run;

pub use self::{
    design::{GeneratorDesign, ResidualForm},
    run::FormGenerator,
};
pub(crate) use self::{
    frequency::{frequency_grid, is_clear, peak_gain},
    part::design_by_part,
};
