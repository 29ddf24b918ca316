//! The contract of an outside simulator, as stated by itself or by its user.

use fd_model::{Channel, SampleTime, nearest};
use serde::{Deserialize, Serialize};

use super::{error::OutsideError, native::natives, powers::Powers};
use crate::{
    model::{DEFAULT_TOLERANCE, Parameter},
    simulate::{Initial, NativeEffect, Port},
};

/// What an outside simulator is: its channels, what can be set, and what it can do.
#[derive(Clone, Debug, PartialEq)]
pub struct Contract {
    /// Name of the simulator.
    pub name: String,
    /// Time between its steps.
    pub ts: SampleTime,
    /// Inputs of a sample.
    pub inputs: Vec<Channel>,
    /// Outputs of a sample.
    pub outputs: Vec<Channel>,
    /// Standard deviation of the noise of each output, in its unit, where it is known.
    pub noise: Vec<Option<f64>>,
    /// Parameters that can be set, those of native effects last.
    pub parameters: Vec<Parameter>,
    /// Effects that it has in itself and that rest.
    pub natives: Vec<NativeEffect>,
    /// States of which the initial value can be set.
    pub initial: Vec<Initial>,
    /// Places at which a force can be applied.
    pub ports: Vec<Port>,
    /// What the force at each port moves.
    pub motion: Vec<Motion>,
    /// What it can do.
    pub powers: Powers,
}

/// The outputs that are the position and the velocity of what a force moves.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Motion {
    /// Name of the output that is the position.
    pub position: Option<String>,
    /// Name of the output that is the velocity.
    pub velocity: Option<String>,
}

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

pub(super) fn wrong(
    place: &str,
    key: impl Into<String>,
    expected: impl Into<String>,
    found: impl std::fmt::Display,
) -> OutsideError {
    let (key, expected, found) = (key.into(), expected.into(), found.to_string());
    OutsideError::Value { place: place.to_owned(), key, expected, found }
}

fn code(names: &[&str]) -> String {
    if names.is_empty() { "none".to_owned() } else { format!("`{}`", names.join("`, `")) }
}

impl Stated {
    /// The rooms with their entries.
    fn rooms(&self) -> [(&'static str, &'static [&'static str], &[Entry]); 6] {
        let Self { inputs, outputs, parameters, states, ports, native_effects, .. } = self;
        let lists = [inputs, outputs, parameters, states, ports, native_effects];
        std::array::from_fn(|i| (ROOMS[i].0, ROOMS[i].1, lists[i].as_slice()))
    }

    /// The contract that this says by itself; `place` is who says it, for messages.
    ///
    /// ```
    /// use fd_sim::outside::{Entry, Stated};
    ///
    /// let entry = |name: &str| Entry { name: name.to_owned(), ..Entry::default() };
    /// let stated = Stated { sample_time: Some(0.1), outputs: vec![entry("y")], ..Stated::default() };
    /// let error = stated.contract("tank").unwrap_err();
    /// assert_eq!(error.to_string(), "tank: outputs.y: expected a unit, `1` for a pure number, found none");
    /// ```
    ///
    /// # Errors
    ///
    /// Returns the first entry that is wrong or missing.
    pub fn contract(self, place: &str) -> Result<Contract, OutsideError> {
        self.check(place)?;
        self.settle(place)
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

    /// The contract that this says, complete and in order.
    pub(super) fn settle(self, place: &str) -> Result<Contract, OutsideError> {
        let ts = self.sample_time.ok_or_else(|| wrong(place, "sample_time", "seconds", "none"))?;
        let is_fine = |value: f64| value.is_finite() && 0.0 < value;
        if !is_fine(ts) {
            return Err(wrong(place, "sample_time", "seconds above 0", ts));
        }
        let ts = SampleTime::new(ts).map_err(|e| wrong(place, "sample_time", "seconds", e))?;
        if self.outputs.is_empty() {
            return Err(wrong(place, "outputs", "at least one", "none"));
        }
        for (room, _, entries) in self.rooms() {
            if let Some(e) = entries.iter().find(|e| e.unit.is_none()) {
                let key = format!("{room}.{}", e.name);
                return Err(wrong(place, key, "a unit, `1` for a pure number", "none"));
            }
        }
        let mut powers = self.powers.unwrap_or_default();
        powers.check(place)?;
        powers.measure &= powers.step;
        let channel = |e: &Entry| {
            Channel::new(&e.name, e.unit.as_deref().unwrap_or("1")).wrapping(e.wraps == Some(true))
        };
        let outputs: Vec<Channel> = self.outputs.iter().map(channel).collect();
        if let Some(output) = outputs.iter().find(|o| o.wraps && o.circle().is_line()) {
            let expected = "`wraps` with a unit of angles, `rad`, `deg` or `rev`";
            let found = format!("`{}`", output.unit);
            return Err(wrong(place, format!("outputs.{}", output.name), expected, found));
        }
        let parameters = self.parameters.iter().map(|e| parameter(e, place));
        let initial = self.states.iter().map(|e| {
            let value = e.initial.unwrap_or(0.0);
            let tolerance = e.tolerance.filter(|tolerance| *tolerance != 0.0);
            let key = || format!("states.{}", e.name);
            if !value.is_finite() {
                return Err(wrong(place, key(), "a finite initial value", value));
            }
            if let Some(t) = tolerance.filter(|t| !is_fine(*t)) {
                return Err(wrong(place, key(), "a tolerance in its unit", t));
            }
            Ok(Initial { channel: channel(e), value, tolerance })
        });
        let names: Vec<&str> = outputs.iter().map(|output| output.name.as_str()).collect();
        let motion = self.ports.iter().map(|e| {
            for output in [&e.position, &e.velocity].into_iter().flatten() {
                if !names.contains(&output.as_str()) {
                    let expected = format!("an output out of {}", code(&names));
                    let found = format!("`{output}`");
                    return Err(wrong(place, format!("ports.{}", e.name), expected, found));
                }
            }
            Ok(Motion { position: e.position.clone(), velocity: e.velocity.clone() })
        });
        if let Some(e) = self.outputs.iter().find(|e| e.noise.is_some_and(|n| !is_fine(n))) {
            let found = e.noise.unwrap_or_default();
            return Err(wrong(place, format!("outputs.{}", e.name), "noise above 0", found));
        }
        let natives = natives(&self, place)?;
        let mut parameters = parameters.collect::<Result<Vec<_>, _>>()?;
        parameters.extend(natives.iter().map(|native| native.parameter.clone()));
        Ok(Contract {
            name: self.name.unwrap_or_else(|| "simulator".to_owned()),
            ts,
            inputs: self.inputs.iter().map(channel).collect(),
            noise: self.outputs.iter().map(|e| e.noise).collect(),
            parameters,
            natives,
            initial: initial.collect::<Result<_, _>>()?,
            motion: motion.collect::<Result<_, _>>()?,
            ports: self.ports.iter().map(|e| Port { channel: channel(e) }).collect(),
            outputs,
            powers,
        })
    }
}

fn parameter(e: &Entry, place: &str) -> Result<Parameter, OutsideError> {
    let key = || format!("parameters.{}", e.name);
    let value = e.value.ok_or_else(|| wrong(place, key(), "a value", "none"))?;
    let tolerance = e.tolerance.unwrap_or(DEFAULT_TOLERANCE);
    if !value.is_finite() {
        return Err(wrong(place, key(), "a finite value", value));
    }
    if !tolerance.is_finite() || tolerance < 0.0 {
        return Err(wrong(place, key(), "a tolerance from 0 on, relative to the value", tolerance));
    }
    if let Some([low, high]) = e.bounds.filter(|[low, high]| !(low <= &value && &value <= high)) {
        let expected = format!("bounds around its value {value}");
        return Err(wrong(place, key(), expected, format!("[{low}, {high}]")));
    }
    let unit = e.unit.clone().unwrap_or_else(|| "1".to_owned());
    Ok(Parameter { name: e.name.clone(), unit, value, tolerance, bounds: e.bounds })
}
