//! Directional residuals: the Beard fault detection filter.
//!
//! * **Equation.** An observer whose gain makes each event direction `l_i` of the states an
//!   eigenvector, `(A − L C) l_i = λ l_i`, so that fault `i` keeps the residual on the line `C l_i`
//!   for ever: `L = (A E − λ E)(C E)⁺ + Z (I − C E (C E)⁺)` with `E = [l_1 … l_q]` (Beard 1971;
//!   White and Speyer 1987). With as many independent outputs as states, `L = (A + σ I) C⁺` does
//!   so for every direction, and a fault of sensor `j` stays in the plane of `I_j` and `C L_j`
//!   (Chen, Patton and Zhang 1996).
//! * **Isolation.** The part of the residual that leaves a fault's line or plane,
//!   `‖r − P_i r‖ / ‖r‖`, is near zero for the true fault: [`FaultSpans`].
//! * **Assumptions.** `C E` has full column rank, so that `q` faults need `q` outputs; zeros from
//!   the events to the outputs decay.
//! * **Do not use** it with an uncertain model unless the residual is robust first: modelling
//!   errors tilt the direction, and a small fault is then taken for another (table 1 of the
//!   paper). Decouple first ([`unknown_input`](crate::unknown_input)), and use [`FaultSpans`] on
//!   that residual.

mod design;
mod spans;

pub use self::{design::BeardDesign, spans::FaultSpans};
