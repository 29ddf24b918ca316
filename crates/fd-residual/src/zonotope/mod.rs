//! Residuals with guaranteed bounds: an observer that carries a set of states.
//!
//! * **Equation.** The state lies in a zonotope `X = c ⊕ H [−1, 1]^p`. With `x⁺ = (A + δA) x + (B + δB) u + E w` and
//!   `y = (C + δC) x + (D + δD) u + v`, where `|w| ≤ 1`, `|v| ≤ σ` and `|δA| ≤ ΔA`, … by entries,
//!   `X⁺ = (A − L C) X ⊕ (B − L D) u + L y ⊕ E [−1, 1]^q ⊕ (−L) box(β) ⊕ box(ΔA |X| + ΔB |u|)` with
//!   `β = σ + ΔC |X| + ΔD |u|` (Combastel 2003, the observer form after Puig 2010). The residual is
//!   `r_i = (y_i − C_i c − D_i u) / (Σ_j |C_i h_j| + β_i)`: as long as everything is within its bounds, `|r_i| ≤ 1`.
//!   Columns beyond a limit are replaced by a box around them ([`Zonotope::reduce`]: Combastel 2003, Alamo, Bravo and
//!   Camacho 2005, in the order of Girard 2005).
//! * **Assumptions.** The bounds hold, at every sample. The uncertain entries may change from sample to sample, each
//!   by itself. Rounding is not bounded: leave it the margin of `1e-12` or so that it needs.
//! * **Do not use** it where noise has no bound that deserves the name: a bound of four standard deviations is exceeded
//!   now and then, and one of ten hides what a [Kalman filter](crate::observer) with a calibrated threshold would find.
//!   Nor for small faults under much uncertainty: `|r| ≤ 1` only says that *some* plant within the bounds explains the
//!   sample. Do not subtract a learned bias from this residual, the promise is lost with it. Do not give all states
//!   units of their own choice: a reduction compares columns by their length, so scale first. And a lasting fault
//!   moves the set: as with any observer, `r` may return below one while the fault is still there.

mod design;
mod run;
mod set;

pub use self::{
    design::{Bounds, ModelBounds, ZonotopeDesign},
    run::ZonotopeObserver,
    set::Zonotope,
};
