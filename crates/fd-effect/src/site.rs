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
    /// Several inputs, forces or outputs that are made alike: one law with the same strength at each; and their names.
    Alike(Vec<SiteRef>, String),
    /// No place in particular.
    WholeModel,
}

impl SiteRef {
    /// Several places that are made alike.
    pub(crate) fn alike(places: Vec<Self>) -> Self {
        let names: Vec<&str> = places.iter().filter_map(Self::name).collect();
        let names = names.join(", ");
        Self::Alike(places, names)
    }

    /// The places that it stands for: one, if it is not several that are made alike.
    #[must_use]
    pub fn each(&self) -> &[Self] {
        match self {
            Self::Alike(places, _) => places,
            one => std::slice::from_ref(one),
        }
    }

    /// Beginning of the names of what an effect adds to a model there.
    #[must_use]
    pub fn prefix(&self) -> String {
        match self {
            Self::Alike(..) => "alike".to_owned(),
            one => one.name().map_or_else(|| "plant".to_owned(), as_name),
        }
    }

    /// Name of the input, site, state, output, signal, parameter or part; of several places all names.
    #[must_use]
    pub fn name(&self) -> Option<&str> {
        match self {
            Self::Input(_, name)
            | Self::Force(_, name)
            | Self::State(_, name)
            | Self::Output(_, name)
            | Self::Signal(_, name)
            | Self::Parameter(_, name)
            | Self::Part(_, name)
            | Self::Alike(_, name) => Some(name),
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
    /// Several inputs, with the same strength at each: their names.
    Inputs(String),
    /// Several named places for forces, with the same strength at each.
    Forces(String),
    /// Several outputs, with the same strength at each.
    Outputs(String),
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
            SiteRef::Alike(places, names) => match places.first() {
                Some(SiteRef::Input(..)) => Self::Inputs(names),
                Some(SiteRef::Output(..)) => Self::Outputs(names),
                _ => Self::Forces(names),
            },
            SiteRef::WholeModel => Self::Model,
        }
    }
}

/// The text with `_` for what cannot stand in a name; places of equations have none of that.
fn as_name(text: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let name: String = text.chars().map(plain).collect();
    if name.starts_with(|c: char| c.is_ascii_digit()) { format!("x_{name}") } else { name }
}
