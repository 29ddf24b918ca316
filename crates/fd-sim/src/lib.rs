//! Simulators that can be patched: equations as text, linear models, black boxes in a shell of equations.
//!
//! | room | what it is for |
//! |---|---|
//! | [`equation`] | expressions as text, as trees and as bytecode |
//! | [`model`] | model files made of such expressions |
//! | [`simulate`] | the contract of a simulator, and those that fulfil it |
//! | [`scales`] | sizes of all signals in a simulation |
//! | [`patch`] | effects spliced into a model, which stays a model |

pub mod equation;
pub mod model;
pub mod patch;
pub mod scales;
pub mod simulate;
