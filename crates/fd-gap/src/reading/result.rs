//! The reported mistake of reading.

use schemars::JsonSchema;
use serde::Serialize;

use super::mistake::Mistake;

/// The log, or the model, says something else than it seems to.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Reading {
    /// What is read wrongly; of several that this log cannot tell apart the likeliest.
    pub mistake: Mistake,
    /// Mistakes that this log cannot tell from it.
    pub also: Vec<Mistake>,
    /// Probability that it is one of these.
    pub probability: f64,
    /// What is wrong, in words that go on "the log reads as if".
    pub statement: String,
    /// How to mend it, in a sentence.
    pub advice: String,
    /// What to write, as lines of a column map or of the model file; empty where neither can say it.
    pub lines: String,
    /// Root mean square error of each output with the best explanation of the log as read, in the unit of the output.
    pub before: Vec<f64>,
    /// The same with the mistake mended, and nothing but parameters and starts refitted.
    pub after: Vec<f64>,
}
