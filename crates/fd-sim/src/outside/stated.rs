//! What a hello or a file says of an outside simulator.

use fd_model::nearest;
use serde::{Deserialize, Serialize};

use super::{
    error::{OutsideError, wrong},
    powers::Powers,
};

/// What a hello or a file says; what is left out is for the other one to say.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Stated {
    /// Name of the simulator.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Time between steps, in seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sample_time: Option<f64>,
    /// Inputs.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub inputs: Vec<Entry>,
    /// Outputs.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub outputs: Vec<Entry>,
    /// Parameters.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parameters: Vec<Entry>,
    /// States that can be set at the start.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub states: Vec<Entry>,
    /// Ports.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub ports: Vec<Entry>,
    /// Effects of its own, at rest.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub native_effects: Vec<Entry>,
    /// Powers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub powers: Option<Powers>,
}

/// What is said of one channel, parameter, state or port.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Entry {
    /// Its name; in a file it is the key.
    pub name: String,
    /// Its unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Nominal value of a parameter, or value at which a native effect rests.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// Nominal initial value of a state.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub initial: Option<f64>,
    /// How well it is known: of a parameter relative to its value, of a state in its unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// Values of a parameter that make sense.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bounds: Option<[f64; 2]>,
    /// Standard deviation of the noise of an output.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<f64>,
    /// Whether an output is an angle that begins anew after a turn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wraps: Option<bool>,
    /// Output that is the position of what a port moves.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<String>,
    /// Output that is the velocity of what a port moves.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<String>,
    /// Label of a native effect.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// Its mechanism.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub family: Option<String>,
    /// Where it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub place: Option<String>,
    /// Change of its parameter that is noticed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<f64>,
    /// Whether `1/value` is what a person would call it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reciprocal: Option<bool>,
    /// Variable of an FMU that it is, if that has another name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub variable: Option<String>,
}

/// What may be said of the entries of a room.
const ROOMS: [(&str, &[&str]); 6] = [
    ("inputs", &["unit", "variable"]),
    ("outputs", &["unit", "noise", "wraps", "variable"]),
    ("parameters", &["unit", "value", "tolerance", "bounds", "variable"]),
    ("states", &["unit", "initial", "tolerance", "variable"]),
    ("ports", &["unit", "position", "velocity", "variable"]),
    (
        "native_effects",
        &["unit", "value", "bounds", "label", "family", "place", "size", "reciprocal", "variable"],
    ),
];

impl Entry {
    /// What is said of it.
    fn said(&self) -> Vec<&'static str> {
        let all = [
            ("unit", self.unit.is_some()),
            ("value", self.value.is_some()),
            ("initial", self.initial.is_some()),
            ("tolerance", self.tolerance.is_some()),
            ("bounds", self.bounds.is_some()),
            ("noise", self.noise.is_some()),
            ("wraps", self.wraps.is_some()),
            ("position", self.position.is_some()),
            ("velocity", self.velocity.is_some()),
            ("label", self.label.is_some()),
            ("family", self.family.is_some()),
            ("place", self.place.is_some()),
            ("size", self.size.is_some()),
            ("reciprocal", self.reciprocal.is_some()),
            ("variable", self.variable.is_some()),
        ];
        all.into_iter().filter(|(_, is_said)| *is_said).map(|(key, _)| key).collect()
    }

    /// This, and what `other` says beyond it.
    fn or(self, other: Self) -> Self {
        Self {
            name: self.name,
            unit: self.unit.or(other.unit),
            value: self.value.or(other.value),
            initial: self.initial.or(other.initial),
            tolerance: self.tolerance.or(other.tolerance),
            bounds: self.bounds.or(other.bounds),
            noise: self.noise.or(other.noise),
            wraps: self.wraps.or(other.wraps),
            position: self.position.or(other.position),
            velocity: self.velocity.or(other.velocity),
            label: self.label.or(other.label),
            family: self.family.or(other.family),
            place: self.place.or(other.place),
            size: self.size.or(other.size),
            reciprocal: self.reciprocal.or(other.reciprocal),
            variable: self.variable.or(other.variable),
        }
    }
}

pub(super) fn code(names: &[&str]) -> String {
    if names.is_empty() { "none".to_owned() } else { format!("`{}`", names.join("`, `")) }
}

impl Stated {
    /// The rooms with their entries.
    pub(super) fn rooms(&self) -> [(&'static str, &'static [&'static str], &[Entry]); 6] {
        let Self { inputs, outputs, parameters, states, ports, native_effects, .. } = self;
        let lists = [inputs, outputs, parameters, states, ports, native_effects];
        std::array::from_fn(|i| (ROOMS[i].0, ROOMS[i].1, lists[i].as_slice()))
    }

    /// Checks that nothing is said where it means nothing, and no name twice; `place` is for messages.
    pub(super) fn check(&self, place: &str) -> Result<(), OutsideError> {
        for (room, allowed, entries) in self.rooms() {
            for (i, entry) in entries.iter().enumerate() {
                let key = format!("{room}.{}", entry.name);
                if entry.name.trim().is_empty() {
                    return Err(wrong(place, room, "a name for every entry", "an empty one"));
                }
                if entries[..i].iter().any(|e| e.name == entry.name) {
                    return Err(wrong(place, key, "every name once", "it twice"));
                }
                if let Some(said) = entry.said().into_iter().find(|said| !allowed.contains(said)) {
                    return Err(wrong(place, key, code(allowed), format!("`{said}`")));
                }
            }
        }
        Ok(())
    }

    /// What the simulator says of itself, with what its file says: the names and their order are those of the
    /// simulator where it gives any, values are those of the file where it gives any.
    pub(super) fn over(self, own: Self, place: &str) -> Result<Self, OutsideError> {
        let room = |name: &str, said: Vec<Entry>, own: Vec<Entry>| {
            if own.is_empty() {
                return Ok(said);
            }
            let known: Vec<&str> = own.iter().map(|entry| entry.name.as_str()).collect();
            if let Some(entry) = said.iter().find(|entry| !known.contains(&entry.name.as_str())) {
                let near = nearest(&entry.name, known.iter().copied());
                let hint = near.first().map_or(String::new(), |n| format!("; did you mean `{n}`?"));
                let found = format!("`{}`{hint}", entry.name);
                return Err(wrong(place, name, format!("names out of {}", code(&known)), found));
            }
            let find = |entry: &Entry| said.iter().find(|e| e.name == entry.name).cloned();
            Ok(own.iter().map(|o| find(o).map_or(o.clone(), |said| said.or(o.clone()))).collect())
        };
        Ok(Self {
            name: self.name.or(own.name),
            sample_time: own.sample_time.or(self.sample_time),
            inputs: room("inputs", self.inputs, own.inputs)?,
            outputs: room("outputs", self.outputs, own.outputs)?,
            parameters: room("parameters", self.parameters, own.parameters)?,
            states: room("states", self.states, own.states)?,
            ports: room("ports", self.ports, own.ports)?,
            native_effects: room("native_effects", self.native_effects, own.native_effects)?,
            powers: own.powers.or(self.powers),
        })
    }
}
