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
//! | [`locate`](mod@locate) | where the gap lies: output, side, equation, frequency, region, time |
//! | [`experiment`] | the experiment that would separate what this log cannot |
//! | [`calibrate`] | the expected confusion matrix of this log |
//! | [`ceiling`](mod@ceiling) | how much a black-box compensation could remove |
//! | [`patch`] | effects spliced into a model, which stays a model |
//! | [`effect`] | the library of effects, as candidates at every site of a model |

pub mod calibrate;
pub mod ceiling;
pub mod diagnose;
pub mod effect;
pub mod equation;
pub mod evidence;
pub mod experiment;
pub mod fit;
pub mod locate;
pub mod model;
pub mod patch;
pub mod quality;
pub mod shrink;
pub mod simulate;
