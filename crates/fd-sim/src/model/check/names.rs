//! All names of a model, each given once.

use std::collections::HashMap;

use super::super::{
    draft::Draft,
    error::{Mistake, ModelError},
};
use crate::equation::is_name;

/// Most characters of a name.
const LONGEST_NAME: usize = 256;

/// What a name stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    Parameter,
    Input,
    DrivenInput,
    State,
    Output,
    Definition,
    Delay,
    Sign,
    Site,
    Table,
    Reference,
    ControllerState,
    ControllerDefinition,
}

impl Meaning {
    pub(super) fn description(self) -> &'static str {
        match self {
            Self::Parameter => "a parameter",
            Self::Input => "an input",
            Self::DrivenInput => "an input that the controller drives",
            Self::State => "a state of the plant",
            Self::Output => "an output",
            Self::Definition => "a definition of the plant",
            Self::Delay => "a delay",
            Self::Sign => "the sign of a velocity",
            Self::Site => "a site",
            Self::Table => "a table",
            Self::Reference => "a reference of the controller",
            Self::ControllerState => "a state of the controller",
            Self::ControllerDefinition => "a definition of the controller",
        }
    }
}

/// Every name with its meaning and key.
pub(super) fn collect(draft: &Draft) -> Result<HashMap<&str, (Meaning, String)>, ModelError> {
    let mut names: HashMap<&str, (Meaning, String)> = HashMap::new();
    for (name, meaning, room) in all(draft) {
        let key = format!("{room}.{name}");
        if !is_name(name) || LONGEST_NAME < name.len() {
            return Err(ModelError::new(key, Mistake::BadName(name.to_owned())));
        }
        if let Some((_, first)) = names.get(name) {
            let (name, first) = (name.to_owned(), first.clone());
            return Err(ModelError::new(key, Mistake::Duplicate { name, first }));
        }
        names.insert(name, (meaning, key));
    }
    check_signals_are_unique(draft)?;
    Ok(names)
}

fn all(draft: &Draft) -> Vec<(&str, Meaning, &'static str)> {
    let mut all: Vec<(&str, Meaning, &'static str)> = Vec::new();
    all.extend(
        draft.parameters.iter().map(|p| (p.name.as_str(), Meaning::Parameter, "parameters")),
    );
    all.extend(draft.inputs.iter().map(|i| {
        let meaning = if draft.is_driven(&i.name) { Meaning::DrivenInput } else { Meaning::Input };
        (i.name.as_str(), meaning, "inputs")
    }));
    all.extend(draft.states.iter().map(|s| (s.name.as_str(), Meaning::State, "states")));
    all.extend(draft.outputs.iter().map(|o| (o.name.as_str(), Meaning::Output, "outputs")));
    all.extend(
        draft.definitions.iter().map(|d| (d.name.as_str(), Meaning::Definition, "definitions")),
    );
    all.extend(draft.delays.iter().map(|d| (d.name.as_str(), Meaning::Delay, "delays")));
    all.extend(draft.signs.iter().map(|s| (s.name.as_str(), Meaning::Sign, "signs")));
    all.extend(draft.sites.iter().map(|s| (s.name.as_str(), Meaning::Site, "sites")));
    all.extend(draft.tables.iter().map(|t| (t.name.as_str(), Meaning::Table, "tables")));
    if let Some(c) = &draft.controller {
        let references = c.references.iter().map(|r| r.name.as_str());
        all.extend(references.map(|name| (name, Meaning::Reference, "controller.references")));
        let states = c.states.iter().map(|s| s.name.as_str());
        all.extend(states.map(|name| (name, Meaning::ControllerState, "controller.states")));
        let definitions = c.definitions.iter().map(|d| d.name.as_str());
        all.extend(
            definitions.map(|name| (name, Meaning::ControllerDefinition, "controller.definitions")),
        );
    }
    all
}

fn check_signals_are_unique(draft: &Draft) -> Result<(), ModelError> {
    let signals: Vec<&str> =
        draft.controller.iter().flat_map(|c| &c.signals).map(|s| s.input.as_str()).collect();
    for (i, input) in signals.iter().enumerate() {
        if signals[..i].contains(input) {
            let key = format!("controller.signals.{input}");
            let mistake = Mistake::Duplicate { name: (*input).to_owned(), first: key.clone() };
            return Err(ModelError::new(key, mistake));
        }
    }
    Ok(())
}
