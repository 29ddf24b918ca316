//! Where an effect is: a place in the model, and the side of the plant that it is on.

use schemars::JsonSchema;
use serde::Serialize;

/// Side of the plant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// Between the logged command and the plant.
    Input,
    /// The plant.
    Dynamics,
    /// Between the plant and the logged measurement.
    Output,
}

/// Where an effect is; serialised as kind and name.
///
/// ```
/// use fd_effect::SiteRef;
///
/// let site = serde_json::to_string(&SiteRef::Force(0, "joint".to_owned()))?;
/// assert_eq!(site, r#"{"kind":"force","name":"joint"}"#);
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, JsonSchema)]
#[serde(into = "Site")]
pub enum SiteRef {
    /// An input of the plant, by its place in [`Draft::inputs`](fd_sim::model::Draft::inputs).
    Input(usize, String),
    /// A named place for forces, by its place in [`Draft::sites`](fd_sim::model::Draft::sites).
    Force(usize, String),
    /// A state of the plant, by its place in [`Draft::states`](fd_sim::model::Draft::states).
    State(usize, String),
    /// An output, by its place in [`Draft::outputs`](fd_sim::model::Draft::outputs).
    Output(usize, String),
    /// A signal inside the model, by its place in [`Draft::definitions`](fd_sim::model::Draft::definitions).
    Signal(usize, String),
    /// A parameter, by its place in [`Draft::parameters`](fd_sim::model::Draft::parameters).
    Parameter(usize, String),
    /// A part of a simulator outside of this program, by its place among the native effects.
    Part(usize, String),
    /// No place in particular.
    WholeModel,
}

impl SiteRef {
    /// Name of the input, site, state, output, signal, parameter or part.
    #[must_use]
    pub fn name(&self) -> Option<&str> {
        match self {
            Self::Input(_, name)
            | Self::Force(_, name)
            | Self::State(_, name)
            | Self::Output(_, name)
            | Self::Signal(_, name)
            | Self::Parameter(_, name)
            | Self::Part(_, name) => Some(name),
            Self::WholeModel => None,
        }
    }
}

/// A place in the model, by its name.
#[derive(Serialize, JsonSchema)]
#[serde(tag = "kind", content = "name", rename_all = "kebab-case")]
enum Site {
    /// An input of the plant.
    Input(String),
    /// A named place for forces.
    Force(String),
    /// The equation of a state.
    State(String),
    /// An output.
    Output(String),
    /// A signal inside the model.
    Signal(String),
    /// A parameter.
    Parameter(String),
    /// A part of a simulator outside of this program.
    Part(String),
    /// No place in particular.
    Model,
}

impl From<SiteRef> for Site {
    fn from(site: SiteRef) -> Self {
        match site {
            SiteRef::Input(_, name) => Self::Input(name),
            SiteRef::Force(_, name) => Self::Force(name),
            SiteRef::State(_, name) => Self::State(name),
            SiteRef::Output(_, name) => Self::Output(name),
            SiteRef::Signal(_, name) => Self::Signal(name),
            SiteRef::Parameter(_, name) => Self::Parameter(name),
            SiteRef::Part(_, name) => Self::Part(name),
            SiteRef::WholeModel => Self::Model,
        }
    }
}
