//! Changes that touch every expression or every name of a draft.

use std::collections::HashSet;

use super::draft::{Controller, Definition, Delay, Draft, Output, Site, State};
use crate::equation::Expr;

/// Names that a model does not have, given out once each.
pub(crate) struct FreshNames {
    taken: HashSet<String>,
}

impl FreshNames {
    pub(crate) fn of(mut draft: Draft) -> Self {
        Self { taken: draft.names_mut().into_iter().map(std::mem::take).collect() }
    }

    /// These are taken as well.
    pub(crate) fn besides(mut self, names: impl IntoIterator<Item = String>) -> Self {
        self.taken.extend(names);
        self
    }

    /// `wish`, or `wish_2`, `wish_3`, …
    pub(crate) fn take(&mut self, wish: &str) -> String {
        let numbered = (2..).map(|n: usize| format!("{wish}_{n}"));
        let mut all = std::iter::once(wish.to_owned()).chain(numbered);
        let name = all.find(|name| !self.taken.contains(name)).unwrap_or_default();
        self.taken.insert(name.clone());
        name
    }
}

impl Draft {
    /// The expressions of the plant: laws, outputs, definitions, sites and what is delayed.
    pub fn plant_expressions_mut(&mut self) -> Vec<&mut Expr> {
        let Self { states, outputs, definitions, sites, delays, .. } = self;
        plant(states, outputs, definitions, sites, delays.iter_mut().map(|delay| &mut delay.value))
    }

    /// All expressions: those of the plant, limits of inputs, times of delays and those of the
    /// controller.
    pub fn expressions_mut(&mut self) -> Vec<&mut Expr> {
        let Self { inputs, states, outputs, definitions, sites, delays, controller, .. } = self;
        let (delayed, times): (Vec<_>, Vec<_>) =
            delays.iter_mut().map(|Delay { value, time, .. }| (value, time)).unzip();
        let mut all = plant(states, outputs, definitions, sites, delayed);
        all.extend(times);
        all.extend(inputs.iter_mut().flat_map(|input| input.saturation.iter_mut().flatten()));
        if let Some(controller) = controller {
            all.extend(controller.expressions_mut());
        }
        all
    }

    /// Renames whatever is called `from`, where it is declared and wherever it is used.
    pub fn rename(&mut self, from: &str, to: &str) {
        for expr in self.expressions_mut() {
            *expr = expr.rename(from, to);
        }
        for name in self.names_mut() {
            if name == from {
                to.clone_into(name);
            }
        }
    }

    /// A name that nothing in the model has: `wish`, or `wish_2`, `wish_3`, …
    #[must_use]
    pub fn fresh_name(&self, wish: &str) -> String {
        FreshNames::of(self.clone()).take(wish)
    }

    /// Every name, where it is declared or stands as a key.
    fn names_mut(&mut self) -> Vec<&mut String> {
        let mut all: Vec<&mut String> = Vec::new();
        all.extend(self.parameters.iter_mut().map(|entry| &mut entry.name));
        all.extend(self.inputs.iter_mut().map(|entry| &mut entry.name));
        all.extend(self.states.iter_mut().map(|entry| &mut entry.name));
        all.extend(self.outputs.iter_mut().map(|entry| &mut entry.name));
        all.extend(self.definitions.iter_mut().map(|entry| &mut entry.name));
        all.extend(self.delays.iter_mut().map(|entry| &mut entry.name));
        all.extend(self.tables.iter_mut().map(|entry| &mut entry.name));
        for site in &mut self.sites {
            all.push(&mut site.name);
            all.extend(site.enters.iter_mut().map(|(state, _)| state));
        }
        if let Some(controller) = &mut self.controller {
            all.extend(controller.references.iter_mut().map(|entry| &mut entry.name));
            all.extend(controller.states.iter_mut().map(|entry| &mut entry.name));
            all.extend(controller.definitions.iter_mut().map(|entry| &mut entry.name));
            all.extend(controller.signals.iter_mut().map(|entry| &mut entry.input));
        }
        all
    }
}

impl Controller {
    /// All expressions of the controller: laws of its states, definitions, signals.
    pub fn expressions_mut(&mut self) -> Vec<&mut Expr> {
        let mut all: Vec<&mut Expr> = Vec::new();
        all.extend(self.states.iter_mut().map(|state| state.law.expr_mut()));
        all.extend(self.definitions.iter_mut().map(|definition| &mut definition.value));
        all.extend(self.signals.iter_mut().map(|signal| &mut signal.value));
        all
    }
}

fn plant<'a>(
    states: &'a mut [State],
    outputs: &'a mut [Output],
    definitions: &'a mut [Definition],
    sites: &'a mut [Site],
    delayed: impl IntoIterator<Item = &'a mut Expr>,
) -> Vec<&'a mut Expr> {
    let mut all: Vec<&mut Expr> = Vec::new();
    all.extend(states.iter_mut().map(|state| state.law.expr_mut()));
    all.extend(outputs.iter_mut().map(|output| &mut output.value));
    all.extend(definitions.iter_mut().map(|definition| &mut definition.value));
    all.extend(delayed);
    for site in sites {
        all.extend(site.enters.iter_mut().map(|(_, factor)| factor));
        all.extend(&mut site.position);
        all.extend(&mut site.velocity);
    }
    all
}
