//! The contract of an outside simulator, as stated by itself or by its user.

use fd_model::{Channel, SampleTime};

use super::{
    error::{OutsideError, wrong},
    native::natives,
    powers::Powers,
    stated::{Entry, Stated, code},
};
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

impl Stated {
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
