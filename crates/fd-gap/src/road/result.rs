//! The result of a road: a list of causes.

use fd_sim::model::Model;
use schemars::JsonSchema;
use serde::Serialize;

use crate::{diagnose::Cause, shrink::Closed};

/// Several causes, the largest first: near the noise by the evidence of each beside all others, far above it in the order
/// in which they were found.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CauseList {
    /// The causes that were accepted.
    pub causes: Vec<ListedCause>,
    /// Share of the held-out gap of the refitted model that no cause takes away and that is not noise, 0 to 1;
    /// NaN (`null`) without held-out logs.
    pub unexplained: f64,
    /// Share of that gap that is noise, 0 to 1; NaN (`null`) without held-out logs.
    pub noise: f64,
    /// Share of the gap above the noise that all causes together close; `None` without held-out logs.
    pub closed: Option<Closed>,
    /// Why it ends there.
    pub end: End,
    /// Causes that were accepted on the way and that forecasts do not miss with the others there, by label.
    pub dropped: Vec<String>,
    /// The model with all causes in it, refitted together, their parameters adjustable; not serialised.
    #[serde(skip)]
    pub model: Model,
}

/// A cause of a list.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ListedCause {
    /// The cause, with its values beside all others.
    pub cause: Cause,
    /// Probability among the laws that could take its place, together with those that the log cannot tell from it.
    pub probability: f64,
    /// Labels of these.
    pub tied: Vec<String>,
    /// Share of the held-out gap of the refitted model that it takes away, 0 to 1; shares, `unexplained`
    /// and `noise` of a road add up to 1. `None` without held-out logs.
    pub share: Option<f64>,
    /// Share that it closes of the gap that the causes before it have left.
    pub closed: Option<Closed>,
    /// Its probability over that of the best cause beside the same others, curves included; not serialised.
    #[serde(skip)]
    pub odds: f64,
}

/// Why a list ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum End {
    /// What is left is noise.
    AtTheNoise,
    /// No further cause is believed together with the others.
    NothingHelps,
    /// As many causes as were asked for.
    Enough,
}
