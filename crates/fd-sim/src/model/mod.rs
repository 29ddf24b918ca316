//! Models as text: states, inputs, outputs, parameters and equations in a TOML file.
//!
//! [`Draft`] is plain data, in the order of the file. [`Model`] is a draft that was checked:
//! every name is known and used where it may be, definitions do not go round in circles, bounds
//! hold. A model prints itself as the file that loads to the same model, bit for bit; comments
//! are lost.
//!
//! The format is described in `docs/model-equations.md`.

mod check;
mod draft;
mod error;
mod file;
mod linear;
mod print;
mod rename;

use std::{ops::Deref, path::Path, str::FromStr};

use fd_core::Limits;
use fd_model::{Channel, SampleTime, file::read_text};

pub(crate) use self::file::Ordered;
pub(crate) use self::rename::FreshNames;
pub use self::{
    draft::{
        Controller, DEFAULT_TOLERANCE, Definition, Delay, Draft, Hold, Input, Law, NamedTable,
        Output, Parameter, Reference, Sign, Signal, Site, State,
    },
    error::{LoadError, Mistake, ModelError, Place},
    linear::LinearOptions,
};

/// A checked [`Draft`], which it shows through `Deref`.
///
/// ```
/// use fd_sim::model::Model;
///
/// let text = r#"
/// version = 1
/// kind = "equations"
/// name = "lag"
/// sample_time = 0.1
/// [parameters]
/// T = { unit = "s", value = 2.0 }
/// [inputs]
/// u = { unit = "1" }
/// [states]
/// x = { unit = "1", initial = 0.0, derivative = "(u - x)/T" }
/// [outputs]
/// y = { unit = "1", value = "x" }
/// "#;
/// let model: Model = text.parse()?;
/// assert_eq!(model.parameters[0].tolerance, 0.03);
/// assert_eq!(model.to_string().parse::<Model>()?, model);
/// # Ok::<(), fd_sim::model::ModelError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Model(Draft);

impl Deref for Model {
    type Target = Draft;

    fn deref(&self) -> &Draft {
        &self.0
    }
}

impl TryFrom<Draft> for Model {
    type Error = ModelError;

    fn try_from(draft: Draft) -> Result<Self, ModelError> {
        check::check(&draft)?;
        Ok(Self(draft))
    }
}

impl FromStr for Model {
    type Err = ModelError;

    fn from_str(text: &str) -> Result<Self, ModelError> {
        let (draft, places) = file::read(text)?;
        Self::try_from(draft).map_err(|error| error.found_in(&places, text))
    }
}

impl Model {
    /// Loads a model file.
    ///
    /// # Errors
    ///
    /// Returns an error when the file cannot be read or is not a correct model; the message names
    /// the file, line and column.
    pub fn load(path: &Path) -> Result<Self, LoadError> {
        let file = path.display().to_string();
        let text = read_text(path, Limits::default().bytes)
            .map_err(|error| LoadError::Read { file: file.clone(), message: error.to_string() })?;
        text.parse().map_err(|error| LoadError::Model { file, error })
    }

    /// The plain data, to be changed and checked again.
    #[must_use]
    pub fn into_draft(self) -> Draft {
        self.0
    }

    /// Time between samples.
    ///
    /// # Errors
    ///
    /// Never: the sample time of a model was checked.
    pub fn sample_time(&self) -> Result<SampleTime, fd_model::ModelError> {
        SampleTime::new(self.0.sample_time)
    }

    /// Inputs that come from outside, in the order in which a simulation takes them: inputs that
    /// no controller drives, then the references of the controller.
    #[must_use]
    pub fn external_inputs(&self) -> Vec<Channel> {
        let driven = |input: &&Input| !self.0.is_driven(&input.name);
        let free = self.0.inputs.iter().filter(driven).map(|i| Channel::new(&i.name, &i.unit));
        let references = self.0.controller.iter().flat_map(|controller| &controller.references);
        free.chain(references.map(|r| Channel::new(&r.name, &r.unit))).collect()
    }

    /// The plant alone: inputs that a controller drives come from outside.
    ///
    /// ```
    /// use fd_sim::model::Model;
    ///
    /// let tank: Model = r#"
    /// version = 1
    /// kind = "equations"
    /// name = "tank"
    /// sample_time = 0.1
    /// inputs = { u = { unit = "m/s" } }
    /// outputs = { y = { unit = "m", value = "h" } }
    /// states = { h = { unit = "m", initial = 0.0, derivative = "u - h" } }
    /// [controller]
    /// references = { r = { unit = "m" } }
    /// signals = { u = "2*(r - y)" }
    /// "#.parse()?;
    /// assert_eq!(tank.external_inputs()[0].name, "r");
    /// assert_eq!(tank.without_controller()?.external_inputs()[0].name, "u");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error where what is left is no model.
    pub fn without_controller(&self) -> Result<Self, ModelError> {
        let mut draft = self.clone().into_draft();
        draft.controller = None;
        Self::try_from(draft)
    }

    /// Outputs, in the order in which a simulation writes them.
    #[must_use]
    pub fn output_channels(&self) -> Vec<Channel> {
        self.0.outputs.iter().map(Output::channel).collect()
    }

    /// Nominal values of the parameters.
    #[must_use]
    pub fn nominal(&self) -> Vec<f64> {
        self.0.parameters.iter().map(|parameter| parameter.value).collect()
    }

    /// A parameter by its name.
    ///
    /// ```
    /// use fd_sim::model::Model;
    ///
    /// let text = r#"
    /// version = 1
    /// kind = "equations"
    /// name = "cart"
    /// sample_time = 0.01
    /// parameters = { m = { unit = "kg", value = 2.0 } }
    /// inputs = { force = { unit = "N" } }
    /// states = { v = { unit = "m/s", initial = 0.0, derivative = "force/m" } }
    /// outputs = { speed = { unit = "m/s", value = "v" } }
    /// "#;
    /// let model: Model = text.parse()?;
    /// assert_eq!(model.parameter("m").map(|mass| mass.value), Some(2.0));
    /// assert!(model.parameter("k").is_none());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<&Parameter> {
        self.0.parameters.iter().find(|parameter| parameter.name == name)
    }

    /// States in the order in which a simulation takes their initial values: those of the plant,
    /// then those of the controller.
    pub fn all_states(&self) -> impl Iterator<Item = &State> {
        let controller = self.0.controller.iter().flat_map(|controller| &controller.states);
        self.0.states.iter().chain(controller)
    }

    /// Nominal initial values of [`Model::all_states`].
    #[must_use]
    pub fn initial(&self) -> Vec<f64> {
        self.all_states().map(|state| state.initial).collect()
    }
}
