//! What can be wrong with the description of a fault.

use thiserror::Error;

/// A fault cannot be applied as it is described.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FaultError {
    /// A parameter is NaN or infinite.
    #[error("fault: `{parameter}` must be finite, got {value}")]
    NotFinite {
        /// Field of the fault.
        parameter: &'static str,
        /// Value that was given.
        value: f64,
    },
    /// A parameter is outside its range.
    #[error("fault: `{parameter}` must be {expected}, got {value}")]
    Range {
        /// Field of the fault.
        parameter: &'static str,
        /// The range in words, with its unit.
        expected: &'static str,
        /// Value that was given.
        value: f64,
    },
    /// No channel or parameter has this name.
    #[error("fault: there is no {site} `{name}`, only {known:?}")]
    UnknownName {
        /// `"sensor"`, `"actuator"` or `"component"`.
        site: &'static str,
        /// Name that was given.
        name: String,
        /// Names there are.
        known: Vec<String>,
    },
    /// No channel or parameter has this index.
    #[error("fault: there is no {site} {index}, there are {count}, counted from 0")]
    UnknownIndex {
        /// `"sensor"`, `"actuator"` or `"component"`.
        site: &'static str,
        /// Index that was given, from 0.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// Only sensor faults can be laid on a record after the fact.
    #[error(
        "fault on {site} `{name}`: a record shows what came of it, so it needs a simulation with the plant"
    )]
    NeedsPlant {
        /// `"actuator"` or `"component"`.
        site: &'static str,
        /// Name or index of the signal or parameter.
        name: String,
    },
}
