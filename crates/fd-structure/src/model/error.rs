//! What can be wrong with a structural model.

use thiserror::Error;

/// A structural model does not make sense.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum StructureError {
    /// Two equations, or two faults, have the same name.
    #[error("there are two {what}s called `{name}`")]
    Twice {
        /// `equation` or `fault`.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// A signal cannot be known and unknown.
    #[error("`{0}` is listed both as an unknown and as a known signal")]
    KnownAndUnknown(String),
    /// A fault enters an equation that does not exist.
    #[error(
        "fault `{fault}` enters equation `{equation}`, which does not exist; there are: {known}"
    )]
    NoSuchEquation {
        /// Name of the fault.
        fault: String,
        /// Name of the equation.
        equation: String,
        /// Names of the equations.
        known: String,
    },
    /// A fault enters nothing.
    #[error("fault `{0}` enters no equation")]
    FaultNowhere(String),
    /// A variable has two rates, is the rate of two variables, or its own rate.
    #[error(
        "`{rate}` as the rate of `{state}`: each state needs one rate of its own, which is not that \
         state and of no other"
    )]
    Rate {
        /// The state.
        state: String,
        /// What is said to be its rate.
        rate: String,
    },
}
