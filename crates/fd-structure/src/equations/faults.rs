//! Where faults are assumed.

use std::{convert::Infallible, str::FromStr};

use fd_sim::{
    equation::Expr,
    model::{Law, Model},
};

use super::error::EquationsError;

/// Which equations of a model may be violated by a fault, one fault each, called `f_` and the name of the entry.
///
/// The default is what is usually asked for: every sensor, every input from outside or from a controller, and every law of
/// motion that is more than the name of another quantity (`theta' = omega` cannot break).
#[derive(Clone, Debug, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "each is a switch of its own")]
pub struct FaultPlaces {
    /// Outputs.
    pub sensors: bool,
    /// Inputs.
    pub actuators: bool,
    /// Laws of states.
    pub laws: bool,
    /// Definitions.
    pub definitions: bool,
    /// Inputs, outputs, states and definitions by name.
    pub named: Vec<String>,
}

impl Default for FaultPlaces {
    fn default() -> Self {
        Self { sensors: true, actuators: true, laws: true, ..Self::none() }
    }
}

/// A list with commas: `sensors`, `actuators`, `laws`, `definitions`, `all`, `none`, and names.
///
/// ```
/// use fd_structure::equations::FaultPlaces;
///
/// let places: FaultPlaces = "sensors, pump".parse()?;
/// assert!(places.sensors && !places.actuators);
/// assert_eq!(places.named, ["pump"]);
/// # Ok::<(), std::convert::Infallible>(())
/// ```
impl FromStr for FaultPlaces {
    type Err = Infallible;

    fn from_str(list: &str) -> Result<Self, Infallible> {
        let mut places = Self::none();
        for item in list.split(',').map(str::trim).filter(|item| !item.is_empty()) {
            match item {
                "sensors" => places.sensors = true,
                "actuators" => places.actuators = true,
                "laws" => places.laws = true,
                "definitions" => places.definitions = true,
                "all" => {
                    let named = std::mem::take(&mut places.named);
                    let (sensors, actuators, laws, definitions) = (true, true, true, true);
                    places = Self { sensors, actuators, laws, definitions, named };
                }
                "none" => {}
                name => places.named.push(name.to_owned()),
            }
        }
        Ok(places)
    }
}

impl FaultPlaces {
    /// No faults.
    #[must_use]
    pub fn none() -> Self {
        let (sensors, actuators, laws, definitions) = (false, false, false, false);
        Self { sensors, actuators, laws, definitions, named: Vec::new() }
    }

    /// Faults with the equations that they enter: sensors, actuators, laws, definitions.
    pub(super) fn of(&self, model: &Model) -> Result<Vec<(String, String)>, EquationsError> {
        let mut entries: Vec<(&str, String, bool)> = Vec::new();
        for output in &model.outputs {
            entries.push((&output.name, format!("sensor {}", output.name), self.sensors));
        }
        for input in &model.inputs {
            let kind = if model.is_driven(&input.name) { "control" } else { "input" };
            entries.push((&input.name, format!("{kind} {}", input.name), self.actuators));
        }
        for state in &model.states {
            let is_identity = matches!(&state.law, Law::Derivative(Expr::Name(_)));
            let wanted = self.laws && !is_identity;
            entries.push((&state.name, format!("law {}", state.name), wanted));
        }
        for definition in &model.definitions {
            let equation = format!("definition {}", definition.name);
            entries.push((&definition.name, equation, self.definitions));
        }
        if let Some(name) = self.named.iter().find(|name| entries.iter().all(|e| e.0 != **name)) {
            let known: Vec<&str> = entries.iter().map(|entry| entry.0).collect();
            return Err(EquationsError::NoPlace { name: name.clone(), known: known.join(", ") });
        }
        let chosen = entries
            .into_iter()
            .filter(|(name, _, wanted)| *wanted || self.named.iter().any(|named| named == name));
        Ok(chosen.map(|(name, equation, _)| (format!("f_{name}"), equation)).collect())
    }
}
