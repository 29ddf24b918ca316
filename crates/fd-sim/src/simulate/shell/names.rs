//! Names of the model of a shell.

/// Those names, in the order of the simulator inside.
#[derive(Clone, Debug, Default)]
pub(super) struct Names {
    /// Raw outputs, as inputs.
    pub raw: Vec<String>,
    /// States that integrate inputs.
    pub integrals: Vec<String>,
    /// Definitions that hand on parameters.
    pub handed_on: Vec<String>,
    /// Definitions that keep native effects at rest, and at which values: theirs are the last of `handed_on`.
    pub resting: Vec<(String, f64)>,
    /// States that integrate forces.
    pub impulses: Vec<String>,
}
