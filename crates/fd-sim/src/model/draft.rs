//! The parts of a model, as plain data.

use fd_model::Channel;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::equation::{Expr, Table};

/// Relative tolerance of a parameter of which the user says nothing.
pub const DEFAULT_TOLERANCE: f64 = 0.03;

/// A model that was not checked.
///
/// Order is kept everywhere: it is the order of inputs, outputs, states and parameters in a
/// simulation. All names share one name space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Draft {
    /// Name of the model.
    pub name: String,
    /// What it is, in a sentence; may be empty.
    pub description: String,
    /// Time between samples, in seconds.
    pub sample_time: f64,
    /// Longest integration step, in seconds; `None` lets the simulator choose.
    pub step: Option<f64>,
    /// Inputs between samples.
    pub hold: Hold,
    /// Constants with a nominal value and a tolerance.
    pub parameters: Vec<Parameter>,
    /// Inputs of the plant.
    pub inputs: Vec<Input>,
    /// States of the plant.
    pub states: Vec<State>,
    /// Measured outputs.
    pub outputs: Vec<Output>,
    /// Named intermediate expressions, in any order.
    pub definitions: Vec<Definition>,
    /// Places at which a generalised force acts.
    pub sites: Vec<Site>,
    /// Expressions as they were some time ago.
    pub delays: Vec<Delay>,
    /// Set-valued signs of velocities.
    pub signs: Vec<Sign>,
    /// Piecewise linear functions.
    pub tables: Vec<NamedTable>,
    /// What closes the loop, if anything does.
    pub controller: Option<Controller>,
}

/// What inputs do between two samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Hold {
    /// They stay.
    #[default]
    Zero,
    /// They go to the next sample in a straight line.
    Linear,
}

/// A constant of the model.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Parameter {
    /// Name in expressions.
    pub name: String,
    /// Unit, `"1"` for a pure number.
    pub unit: String,
    /// Nominal value, in that unit.
    pub value: f64,
    /// How well the value is known, as a fraction of it.
    pub tolerance: f64,
    /// Values that make sense, both ends included, in that unit.
    pub bounds: Option<[f64; 2]>,
}

/// An input of the plant.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    /// Name in expressions.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Lower and upper limit, expressions of parameters: what the equations see is the clamped
    /// value.
    pub saturation: Option<[Expr; 2]>,
}

/// A state.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Name in expressions.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Initial value.
    pub initial: f64,
    /// How well the initial value is known, in the unit; `None` when it is exact.
    pub tolerance: Option<f64>,
    /// What moves it.
    pub law: Law,
}

/// What moves a state.
#[derive(Clone, Debug, PartialEq)]
pub enum Law {
    /// Derivative with respect to time, integrated with the other such states.
    Derivative(Expr),
    /// Value at the end of an integration step, computed from all values at its start; `dt` is
    /// the length of the step. In a model that has no derivatives a step is a sample.
    Update(Expr),
}

/// A measured output.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Output {
    /// Name of the channel.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// What is measured.
    #[schemars(with = "String")]
    pub value: Expr,
    /// Standard deviation of the sensor noise, in the unit, if known.
    pub noise: Option<f64>,
    /// Whether it is an angle that begins anew after a turn.
    pub wraps: bool,
}

impl Output {
    /// An output of which the noise is not known.
    ///
    /// ```
    /// # use fd_sim::{equation::Expr, model::Output};
    /// let output = Output::new("speed", "m/s", Expr::name("v"));
    /// assert_eq!((output.noise, output.wraps), (None, false));
    /// ```
    pub fn new(name: impl Into<String>, unit: impl Into<String>, value: Expr) -> Self {
        Self { name: name.into(), unit: unit.into(), value, noise: None, wraps: false }
    }

    /// Its name and unit, and whether it wraps.
    #[must_use]
    pub fn channel(&self) -> Channel {
        Channel::new(&self.name, &self.unit).wrapping(self.wraps)
    }
}

/// A named intermediate expression.
#[derive(Clone, Debug, PartialEq)]
pub struct Definition {
    /// Name in expressions.
    pub name: String,
    /// What it stands for.
    pub value: Expr,
}

/// An expression as it was some time ago.
///
/// Its name stands for the mean, over an integration step, of the delayed expression, of which
/// every past value was held for a step: `(1 - φ) v[n-m] + φ v[n-m-1]` for a delay of `m + φ` steps.
/// Derivatives see held values switch within a step, outputs see that interpolation. Before the run the
/// expression had the value that it has at its start. A delay that is not positive is the identity.
#[derive(Clone, Debug, PartialEq)]
pub struct Delay {
    /// Name in expressions.
    pub name: String,
    /// What is delayed.
    pub value: Expr,
    /// By how much, in seconds: an expression of parameters.
    pub time: Expr,
}

/// The set-valued sign of a velocity, `s ∈ Sgn(v)`: 1 or -1 where the velocity is positive or negative; at rest whatever
/// keeps it at rest, as long as that is within [-1, 1].
///
/// Dry friction is a level times such a sign. The force has to work against the velocity for all values of the sign, so
/// that more of it leaves less velocity.
#[derive(Clone, Debug, PartialEq)]
pub struct Sign {
    /// Name in expressions.
    pub name: String,
    /// The velocity.
    pub velocity: Expr,
}

/// A place at which a generalised force (force, torque, flow, voltage) acts.
#[derive(Clone, Debug, PartialEq)]
pub struct Site {
    /// Name of the site.
    pub name: String,
    /// Unit of the force.
    pub unit: String,
    /// The states whose derivative the force enters, each with the factor in front of it.
    pub enters: Vec<(String, Expr)>,
    /// The displacement on which the force works, if there is one.
    pub position: Option<Expr>,
    /// The velocity on which the force works, if there is one.
    pub velocity: Option<Expr>,
}

/// A table with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedTable {
    /// Name in expressions.
    pub name: String,
    /// The points.
    pub table: Table,
}

/// A controller that drives inputs of the plant from references and measured outputs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Controller {
    /// Time between two actions, in seconds; between them its signals are held and its states
    /// have update laws. `None` for a continuous controller.
    pub sample_time: Option<f64>,
    /// Inputs from outside.
    pub references: Vec<Reference>,
    /// States of the controller.
    pub states: Vec<State>,
    /// Named intermediate expressions of the controller.
    pub definitions: Vec<Definition>,
    /// What is sent to inputs of the plant.
    pub signals: Vec<Signal>,
}

/// A reference that a controller follows.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Name in expressions of the controller.
    pub name: String,
    /// Unit.
    pub unit: String,
}

/// A control signal.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// Input of the plant that it drives.
    pub input: String,
    /// Its value, before the saturation of the input.
    pub value: Expr,
}

impl Draft {
    /// Whether a controller drives this input.
    #[must_use]
    pub fn is_driven(&self, input: &str) -> bool {
        let mut signals = self.controller.iter().flat_map(|controller| &controller.signals);
        signals.any(|signal| signal.input == input)
    }
}

impl Law {
    /// The expression.
    #[must_use]
    pub fn expr(&self) -> &Expr {
        match self {
            Self::Derivative(expr) | Self::Update(expr) => expr,
        }
    }

    /// The expression, to be changed.
    pub fn expr_mut(&mut self) -> &mut Expr {
        match self {
            Self::Derivative(expr) | Self::Update(expr) => expr,
        }
    }
}

impl Parameter {
    /// A parameter of an effect: not known beforehand, hence with tolerance 0 (no nuisance).
    ///
    /// ```
    /// # use fd_sim::model::Parameter;
    /// let friction = Parameter::new("f_c", "N m", 0.2);
    /// assert_eq!(friction.tolerance, 0.0);
    /// ```
    pub fn new(name: impl Into<String>, unit: impl Into<String>, value: f64) -> Self {
        Self { name: name.into(), unit: unit.into(), value, tolerance: 0.0, bounds: None }
    }
}
