//! The unknown-input directions that describe an uncertain model best, for approximate
//! decoupling.
//!
//! * **Equation.** Modelling errors act like unknown inputs, `x⁺ = A x + B u + E d` with
//!   `E d = ΔA x + ΔB u`. The directions of rank `q` that leave least of the errors' energy over
//!   are the first `q` left singular vectors of the stacked errors, each scaled by its singular
//!   value (Eckart and Young), as Patton and Chen (1991c; Chen and Patton 1999, section 5.3)
//!   choose them.
//! * **From models.** [`Directions::from_models`] stacks `[ΔA_i S_x, ΔB_i S_u]` over several
//!   perturbed models, where `S` holds the root mean squares of states and inputs.
//! * **From data.** [`Directions::from_records`] estimates `E d` in healthy logs by a Kalman
//!   filter for a disturbance of known duration on every state, and takes the principal
//!   directions of the estimates. The same works on `y + μ̂` of an identified bias: what matters
//!   is only the difference to the model.
//! * **Assumptions.** The errors stay in few directions; fewer than there are outputs, or nothing
//!   is left ([`explained`](Directions::explained) tells what a rank leaves over).
//! * **Do not use** directions of a rank near the number of outputs: faults hide in them too.
//!   Directions from data name what the logs excited; a log at rest names noise.

mod directions;
mod estimate;

pub use self::{directions::Directions, estimate::Expectation};
