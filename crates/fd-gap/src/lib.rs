//! Diagnosis of the sim-to-real gap: where it lies, which effect causes it, how far it shrinks.
//!
//! | room | what it is for |
//! |---|---|
//! | [`quality`] | is the log good enough, and how much of it is noise? |
//! | [`fit`] | fits of a simulator to logs, and screening |
//! | [`evidence`] | how strongly a log speaks for a cause |
//! | [`shrink`] | how far a gap shrinks on data that the fit has not seen |
//! | [`diagnose`](mod@diagnose) | all of it, from a model, candidates and logs to an answer |
//! | [`locate`](mod@locate) | where the gap lies: output, side, equation, frequency, region, time |
//! | [`experiment`] | the experiment that would separate what this log cannot |
//! | [`calibrate`] | the expected confusion matrix of this log |
//! | [`ceiling`](mod@ceiling) | how much a black-box compensation could remove |

pub mod calibrate;
pub mod ceiling;
pub mod diagnose;
pub mod evidence;
pub mod experiment;
pub mod fit;
pub mod locate;
pub mod quality;
pub mod shrink;
