//! Several generators side by side as one.
//!
//! * **Equation.** `r = [r₁; r₂; …]`, so `H_u` and `H_y` are stacked; each block is sensitive to
//!   faults of its own, and together they make a structured residual set (Patton and Chen 1992,
//!   section 2).
//! * **Assumptions.** All members watch the same plant.
//! * **Do not use** a bank where one vector residual would do: every member simulates a model.

mod design;
mod run;

pub use self::{design::BankDesign, run::Bank};
