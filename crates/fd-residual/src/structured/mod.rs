//! Structured residuals: a bank in which each residual reacts to its own set of faults.
//!
//! * **Equation.** Row `i` of the structure matrix names the faults that `r_i` must react to; from
//!   all others, and from the disturbances, it is decoupled (Gertler 1991; Patton and Chen 1992,
//!   section 2). Dedicated: one residual per fault, blind to the others. Generalised: one residual
//!   per fault, blind to this one only.
//! * **Rows.** Parity relations of the least order that have the signature
//!   ([`ParityDesign::with_signature`](crate::parity::ParityDesign::with_signature)), or filters
//!   with poles of their own in the left null space ([`decouple`](crate::decouple)).
//! * **Ranks** are decided at a [tolerance](crate::rank); the structure of each residual is then looked at
//!   over frequency, and one that is not what was asked for is refused.
//! * **Assumptions.** The entry directions of all faults are known.
//! * **Do not use** more rows than isolation needs: each costs sensitivity. Ask
//!   [`achievable_signatures`](crate::analysis::achievable_signatures) and
//!   [`isolability`](crate::decouple::isolability) first which structures are achievable.

mod design;
mod structure;

pub use self::{
    design::{RowMethod, StructuredDesign},
    structure::Structure,
};
