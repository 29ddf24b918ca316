//! The expected confusion matrix of a log.

use schemars::JsonSchema;
use serde::Serialize;

use crate::diagnose::CauseId;

/// What a diagnosis of logs like these would answer, whatever the cause is.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Confusion {
    /// True causes, one row each: "no gap" first, then the leading causes.
    pub truths: Vec<Truth>,
    /// Answers, one column each: those of `truths` in the same order, then another cause, then
    /// no answer (unclear, or none of these).
    pub columns: Vec<String>,
    /// Replicas with a true cause (row) and an answer (column).
    pub counts: Vec<Vec<usize>>,
    /// Replicas per row that could be simulated and diagnosed.
    pub replicas: Vec<usize>,
    /// Share of the replicas with the right answer, or one that is tied with it.
    pub accuracy: f64,
    /// Mean of the highest probabilities that the diagnoses gave: above `accuracy` when they are too
    /// sure of themselves.
    pub confidence: f64,
    /// Temperature with which the probabilities of the replicas are the most honest (least mean
    /// `−ln p` of the truth, with a weak prior about the present one); to be used as [`Settings::temperature`](crate::diagnose::Settings).
    pub temperature: f64,
    /// Answers with at least this probability (at that temperature) make up a set that contains the
    /// truth in 90 % of such logs (split conformal prediction).
    pub threshold: f64,
    /// Mean number of answers in that set, over the replicas.
    pub set_size: f64,
    /// That set for the present diagnosis; `None` is "no gap".
    pub set: Vec<Option<CauseId>>,
    /// In words.
    pub statement: String,
}

/// A true cause.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Truth {
    /// The cause; `None` is "no gap".
    pub cause: Option<CauseId>,
    /// In words, such as `coulomb-friction at shaft`.
    pub name: String,
}
