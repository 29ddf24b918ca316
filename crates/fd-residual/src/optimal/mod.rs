//! The residual that keeps faults farthest above the noise at every frequency: `H₋/H∞` optimal.
//!
//! * **Equation.** All residuals that are free of the state and of the disturbances are `Q₂ Q₁`
//!   with a left null space `Q₁` ([`decouple`](crate::decouple)). With the co-outer-co-inner
//!   factorisation `Q₁ G_w = R_o R_i`, `Q₂ = R_o⁻¹` makes the noise in the residual white and of
//!   unit gain, `‖R_w‖∞ = 1`, and `‖R_f,j‖∞` of every fault as large as any `Q₂` with that noise
//!   can (Ding and Frank 1991; Ding 2013, section 7.6, "unified solution"; Varga 2017, algorithm
//!   AFD). `R_o⁻¹` is a stationary Kalman filter, from a Riccati equation.
//! * **Residuals that see no noise.** Where a null space of `[G_u G_d G_w; I 0 0]` is left, its
//!   residuals come last, scaled so that they do not set the gap. Their poles are free:
//!   [`OptimalDesign::placed`] takes them.
//! * **Noise without feedthrough.** Where `R_o⁻¹` would differentiate, it is multiplied by
//!   `(a/(s+a))ᵏ` with the given rate `a` (continuous), or delayed by `k` samples (discrete), with
//!   the least `k` that makes it proper. In continuous time the gap then grows with `a`.
//! * **Assumptions.** Noise filters and their gains are known; `R_o` has no zeros on the frequency
//!   axis, or the Riccati equation has no solution, and says so.
//! * **Do not use** it where the noise model is a guess: the residual is exactly as good as `G_w`.
//!   Nor when the faults may hide inside the disturbance directions: then there is no solution,
//!   and the error names the fault.

mod design;
mod infinity;

pub use self::design::{Exposure, OptimalDesign};
pub(crate) use self::{
    design::loudest,
    infinity::{Regular, regular},
};
