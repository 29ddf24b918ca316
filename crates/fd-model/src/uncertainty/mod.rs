//! Model uncertainty: its forms, random draws of it, and what it does to a residual.
//!
//! | form | equation | here |
//! |------|----------|------|
//! | additive | `G = G_u + ΔG_a` (8a) | [`Uncertainty::Additive`] |
//! | input-multiplicative | `G = G_u (I + ΔG_i)` (8b) | [`Uncertainty::InputMultiplicative`] |
//! | output-multiplicative | `G = (I + ΔG_o) G_u` (8c) | [`Uncertainty::OutputMultiplicative`] |
//! | matrix entries, norms | `A + ΔA`, … | [`MatrixPerturbation`] |
//! | physical parameters | `G(p + Δp)` | [`perturb_parameters`] |
//!
//! Equation numbers are those of R. J. Patton and J. Chen, "On-line residual compensation in
//! robust fault diagnosis of dynamic systems", IFAC AIRTC, Delft, 1992. Whatever its form, the
//! uncertainty leaves the residual `r = H_y ΔG u` (9, 12) without any fault, a transfer `G_ru`
//! (13) from the inputs that [`Uncertainty::residual_transfer`] gives as a model.
//!
//! Use none of this for an uncertainty whose direction is known: decouple it instead.

mod draw;
mod form;
mod matrices;
mod parameters;

pub use self::{
    draw::Draw,
    form::Uncertainty,
    matrices::{MatrixPerturbation, Spread},
    parameters::{ParameterDraw, perturb_parameters},
};
