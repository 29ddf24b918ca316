//! Objections: what speaks against an answer, whatever its probability.

use schemars::JsonSchema;
use serde::Serialize;

/// What an engineer would say against an answer at first sight, whatever its probability.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Objection {
    /// The strengths of a cause are hardly more than their errors.
    FaintStrength {
        /// Label of the cause.
        cause: String,
        /// The largest of them, in standard errors.
        errors: f64,
        /// Whether it is not more than one: then there may as well be none.
        is_none: bool,
    },
    /// At every horizon, held-out logs are forecast worse than by a constant.
    NoBetterThanConstant,
    /// At every horizon, held-out logs are forecast worse than by the last value that was measured.
    NoBetterThanLastValue,
    /// At every horizon, held-out logs are forecast worse than by the model as it came.
    WorseThanNominal,
    /// At every horizon, held-out logs are forecast worse than by the model with its parameters refitted.
    WorseThanRefitted,
    /// At every horizon, held-out logs may as well be forecast worse with it as better, and it is a curve or a path,
    /// which follows anything in the log that it is fitted to.
    NotShown,
    /// Refitted parameters lie at the edges of what their tolerances allow.
    ParametersAtEdges {
        /// Their names.
        names: Vec<String>,
        /// Of so many.
        of: usize,
        /// Whether they are most of them.
        is_most: bool,
        /// Whether held-out logs surely show the cause all the same: small effects that nobody listed may push parameters.
        is_shown: bool,
    },
    /// The log reads what the saturated sensor could not show.
    ReadsBeyondLimit {
        /// The most that it could show, in the unit of the output.
        limit: f64,
        /// What is read, in that unit.
        reads: f64,
    },
}

impl Objection {
    /// Whether no cause may be named in the face of it; the others are said beside the answer.
    #[must_use]
    pub fn forbids(&self) -> bool {
        match self {
            Self::FaintStrength { is_none, .. } => *is_none,
            Self::ParametersAtEdges { is_most, is_shown, .. } => *is_most && !*is_shown,
            Self::NoBetterThanConstant
            | Self::NoBetterThanLastValue
            | Self::WorseThanNominal
            | Self::WorseThanRefitted
            | Self::NotShown
            | Self::ReadsBeyondLimit { .. } => true,
        }
    }
}
