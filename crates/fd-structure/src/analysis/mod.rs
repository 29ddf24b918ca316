//! Which faults can be detected, and told from each other, by any test at all.
//!
//! A fault can be detected when its equation has redundancy: when it lies in the overdetermined part `M+`. A fault
//! can be isolated from another one when it can be detected without the equation of that other
//! one. Neither needs a list of tests. What the structure allows is an upper bound: numbers may cancel, and a
//! fault may be too small for the noise.
//!
//! Tests that may integrate but not differentiate signals, or the other way round, see less:
//! [`Causality`].

mod causality;
mod isolability;

pub use self::{causality::Causality, isolability::Isolability};
