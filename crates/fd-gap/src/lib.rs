//! Diagnosis of the sim-to-real gap: where it lies, which effect causes it, how far it shrinks.
//!
//! | room | what it is for |
//! |---|---|
//! | [`equation`] | expressions as text, as trees and as bytecode |
//! | [`model`] | model files made of such expressions |
//! | [`simulate`] | the contract of a simulator, and those that fulfil it |
//! | [`quality`] | is the log good enough, and how much of it is noise? |
//! | [`fit`] | fits of a simulator to logs, and screening |
//! | [`evidence`] | how strongly a log speaks for a cause |
//! | [`shrink`] | how far a gap shrinks on data that the fit has not seen |
//! | [`diagnose`](mod@diagnose) | all of it, from a model, candidates and logs to an answer |
//! | [`patch`] | effects spliced into a model, which stays a model |
//! | [`effect`] | the library of effects, as candidates at every site of a model |

pub mod diagnose;
pub mod effect;
pub mod equation;
pub mod evidence;
pub mod fit;
pub mod model;
pub mod patch;
pub mod quality;
pub mod shrink;
pub mod simulate;
