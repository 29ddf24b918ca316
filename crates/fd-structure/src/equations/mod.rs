//! Structural models of equation models: the equations of a file, each with what it says.
//!
//! | part of the file | equation | what it relates |
//! |---|---|---|
//! | input `u` | `input u` | `u`, as the plant gets it, and the log, through the saturation |
//! | state `x` | `law x` | its rate `x'` (the next value `x+` of an update) and the names in its law |
//! | | `d/dt x`, `next x` | a dynamic constraint between state and rate |
//! | definition `d` | `definition d` | `d` and the names in it |
//! | delay `d` | `undelayed d`, `delay d` | the expression as it is now; a dynamic constraint |
//! | output `y` | `sensor y` | the log and the names in its value |
//! | controller | `control u`, `law x`, `definition d` | its names, references and the logged outputs |
//!
//! Known are the logs of the outputs and of the inputs that come from outside, written `log.y` in expressions.
//! Parameters, tables and the time are known as well and left out; what depends on nothing else is a constant.

mod error;
mod faults;
mod read;

use fd_sim::{equation::Expr, model::Model};

pub use self::{error::EquationsError, faults::FaultPlaces};
use crate::model::StructuralModel;

/// The name of a logged signal in expressions; a point is not part of the language.
pub(crate) fn logged(name: &str) -> String {
    format!("log.{name}")
}

/// What an equation says.
#[derive(Clone, Debug, PartialEq)]
pub enum Relation {
    /// The left side is the right side, at every instant.
    Equal {
        /// A name: an unknown, or a logged signal.
        left: Expr,
        /// What it is.
        right: Expr,
    },
    /// The same at the instants of a sampled controller; in between, values are held.
    Sampled {
        /// A name.
        left: Expr,
        /// What it is.
        right: Expr,
    },
    /// The rate is the derivative of the state.
    Derivative {
        /// Value of the state at the start of a run.
        initial: f64,
    },
    /// The rate is the value of the state after a step.
    Update {
        /// Value of the state at the start of a run.
        initial: f64,
    },
    /// The state is the rate as it was some time ago.
    Delay,
}

/// A structural model of which every equation is known.
///
/// ```
/// use fd_sim::model::Model;
/// use fd_structure::{analysis::Causality, equations::{EquationModel, FaultPlaces}};
///
/// let tank: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "tank"
/// sample_time = 0.1
/// parameters = { A = { unit = "m^2", value = 0.5 }, c = { unit = "m^2.5/s", value = 0.02 } }
/// inputs = { pump = { unit = "m^3/s" } }
/// states = { h = { unit = "m", initial = 1.0, derivative = "(pump - out)/A" } }
/// definitions = { out = "c*sqrt(h)" }
/// outputs = { level = { unit = "m", value = "h" }, flow = { unit = "m^3/s", value = "out" } }
/// "#.parse()?;
/// let equations = EquationModel::new(&tank, &FaultPlaces::default())?;
/// let structure = equations.structure();
/// assert_eq!(structure.unknowns(), ["pump", "h'", "out", "h"]);
/// // Two sensors, the pump, and the balance of the tank.
/// let faults: Vec<&str> = structure.faults().iter().map(|fault| fault.name.as_str()).collect();
/// assert_eq!(faults, ["f_level", "f_flow", "f_pump", "f_h"]);
/// assert_eq!(structure.isolability(Causality::Mixed).groups(), [vec![0], vec![1], vec![2, 3]]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct EquationModel {
    pub(crate) structure: StructuralModel,
    /// One per equation.
    pub(crate) relations: Vec<Relation>,
    pub(crate) source: Model,
    /// Definitions that depend on parameters and time alone.
    pub(crate) constants: Vec<(String, Expr)>,
}

impl EquationModel {
    /// Which unknowns, known signals and faults are in which equation.
    #[must_use]
    pub fn structure(&self) -> &StructuralModel {
        &self.structure
    }

    /// What each equation says.
    #[must_use]
    pub fn relations(&self) -> &[Relation] {
        &self.relations
    }

    /// An equation as text.
    #[must_use]
    pub fn text_of(&self, equation: usize) -> String {
        let names = self.structure.equations.get(equation).and_then(|equation| equation.dynamics);
        let name = |of: usize| self.structure.unknowns[of].as_str();
        let (state, rate) = names.map_or(("", ""), |d| (name(d.state), name(d.rate)));
        match self.relations.get(equation) {
            Some(Relation::Equal { left, right }) => format!("{left} = {right}"),
            Some(Relation::Sampled { left, right }) => format!("{left} = {right}, when it acts"),
            Some(Relation::Derivative { .. }) => format!("{rate} = d/dt {state}"),
            Some(Relation::Update { .. }) => format!("{rate} = {state} after a step"),
            Some(Relation::Delay) => format!("{state} = {rate}, some time ago"),
            None => String::new(),
        }
    }
}
