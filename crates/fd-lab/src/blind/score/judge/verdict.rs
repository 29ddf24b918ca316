//! What is said of one answer.

use serde::{Deserialize, Serialize};

use crate::blind::kind::CaseKind;

/// One answer next to its truth.
#[allow(clippy::struct_excessive_bools, reason = "each is a question of its own")]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Name of the case.
    pub case: String,
    /// Kind.
    pub kind: String,
    /// Plant.
    pub plant: String,
    /// Whether the noise is coloured.
    pub coloured: bool,
    /// What was put in: label, law, site.
    pub truth: Vec<String>,
    /// Mechanism of the first effect, or `no gap`.
    pub truth_family: String,
    /// What was said first: label, law, site.
    pub said: String,
    /// Its mechanism, or `no gap`.
    pub said_family: String,
    /// Squares of the noise that the best fit without any effect leaves of the truth, see
    /// [`Oracle::nothing`](crate::blind::Oracle::nothing).
    pub distance: f64,
    /// Whether the effect leaves a trace at all.
    pub is_visible: bool,
    /// Whether some other single effect of the library leaves less than 9 squares of the noise.
    pub is_mimicked: bool,
    /// What the nearest single effect of the library leaves, where that was looked for.
    pub nearest: Option<f64>,
    /// Label and site are right.
    pub is_exact: bool,
    /// Right, or not to be told from the truth by this log.
    pub is_right: bool,
    /// Mechanism and site are right, or not to be told from the truth.
    pub is_group_right: bool,
    /// The side of the plant is right, or not to be told from the truth.
    pub is_side_right: bool,
    /// Probability of the first cause and those that the diagnosis cannot tell from it.
    pub probability: f64,
    /// Probability of their mechanism at their site.
    pub group_probability: f64,
    /// Probability that there is a gap.
    pub blamed: f64,
    /// How much speaks for none of the known causes.
    pub none_score: f64,
    /// Whether the diagnosis says "none of these".
    pub says_none: bool,
    /// Whether a single cause was named, without an alternative.
    pub is_alone: bool,
    /// Two effects: both are named, and nothing else.
    pub is_pair_exact: bool,
    /// Two effects: as above, or what is named cannot be told from them.
    pub is_pair_right: bool,
    /// Two effects: at least one is named.
    pub is_half_exact: bool,
    /// Whether the training residual came down to the real noise.
    pub is_floor_reached: bool,
    /// Stated share of the gap that is closed.
    pub closed: Option<f64>,
    /// The real share, from runs that nobody has seen.
    pub really_closed: Option<f64>,
    /// Whether the stated interval contains the real share.
    pub is_covered: Option<bool>,
    /// Time of the diagnosis, in seconds.
    pub seconds: f64,
    /// Names by the refit and by the sparse regression are right.
    pub baseline_right: [bool; 2],
    /// Shares that refit, black box and sparse regression close.
    pub baseline_closed: [Option<f64>; 3],
    /// A list of effects: the largest is named first, or what no log could tell from it.
    pub is_dominant_first: bool,
    /// A list of effects: all are named and nothing else, or the list leaves nothing.
    pub is_list_right: bool,
    /// Several effects: what the log holds of each, and whether it is named.
    #[serde(default)]
    pub of_several: Vec<OfSeveral>,
    /// Several effects: how many of the named causes are among them, label and site, of how many.
    #[serde(default)]
    pub named_of_several: [usize; 2],
    /// A mistake of reading is told as what it is.
    pub is_reading_told: bool,
    /// It is taken for physics: a cause in the plant is stated with a probability above one half.
    pub is_taken_for_physics: bool,
    /// Why there is no diagnosis.
    pub error: Option<String>,
}

impl Verdict {
    /// Whether it is of the first kinds of cases.
    pub(in crate::blind::score) fn is_plain(&self) -> bool {
        CaseKind::ALL.iter().any(|kind| kind.is_plain() && kind.name() == self.kind)
    }
}

/// One of several effects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OfSeveral {
    /// Squares of the noise that all the others leave of the noise-free log, with parameters refitted, at most: what the
    /// log holds of this one.
    pub worth: f64,
    /// Whether it is named, label and site.
    pub is_named: bool,
}
