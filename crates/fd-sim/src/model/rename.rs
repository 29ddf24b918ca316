//! Changes that touch every expression or every name of a draft.

use std::collections::HashSet;

use super::draft::{Controller, Definition, Delay, Draft, Output, Sign, Site, State};
use crate::equation::Expr;

/// All names of a draft, as references of one kind or the other.
macro_rules! every_name {
    ($draft:ident, $iter:ident $(, $mutable:tt)?) => {{
        let mut all: Vec<&$($mutable)? String> = Vec::new();
        all.extend($draft.parameters.$iter().map(|entry| &$($mutable)? entry.name));
        all.extend($draft.inputs.$iter().map(|entry| &$($mutable)? entry.name));
        all.extend($draft.states.$iter().map(|entry| &$($mutable)? entry.name));
        all.extend($draft.outputs.$iter().map(|entry| &$($mutable)? entry.name));
        all.extend($draft.definitions.$iter().map(|entry| &$($mutable)? entry.name));
        all.extend($draft.delays.$iter().map(|entry| &$($mutable)? entry.name));
        all.extend($draft.signs.$iter().map(|entry| &$($mutable)? entry.name));
        all.extend($draft.tables.$iter().map(|entry| &$($mutable)? entry.name));
        for site in &$($mutable)? $draft.sites {
            all.push(&$($mutable)? site.name);
            all.extend(site.enters.$iter().map(|(state, _)| state));
        }
        if let Some(controller) = &$($mutable)? $draft.controller {
            all.extend(controller.references.$iter().map(|entry| &$($mutable)? entry.name));
            all.extend(controller.states.$iter().map(|entry| &$($mutable)? entry.name));
            all.extend(controller.definitions.$iter().map(|entry| &$($mutable)? entry.name));
            all.extend(controller.signals.$iter().map(|entry| &$($mutable)? entry.input));
        }
        all
    }};
}

/// `wish`, or `wish_2`, `wish_3`, …, whichever is not taken.
fn first_free(wish: &str, is_taken: impl Fn(&String) -> bool) -> String {
    let numbered = (2..).map(|n: usize| format!("{wish}_{n}"));
    let mut all = std::iter::once(wish.to_owned()).chain(numbered);
    all.find(|name| !is_taken(name)).unwrap_or_default()
}

/// Names that a model does not have, given out once each.
pub(crate) struct FreshNames {
    taken: HashSet<String>,
}

impl FreshNames {
    pub(crate) fn of(draft: &Draft) -> Self {
        Self { taken: draft.names().into_iter().cloned().collect() }
    }

    /// These are taken as well.
    pub(crate) fn besides(mut self, names: impl IntoIterator<Item = String>) -> Self {
        self.taken.extend(names);
        self
    }

    /// `wish`, or `wish_2`, `wish_3`, …
    pub(crate) fn take(&mut self, wish: &str) -> String {
        let name = first_free(wish, |name| self.taken.contains(name));
        self.taken.insert(name.clone());
        name
    }
}

impl Draft {
    /// The expressions of the plant: laws, outputs, definitions, sites, velocities of signs and what is delayed.
    pub fn plant_expressions_mut(&mut self) -> Vec<&mut Expr> {
        let Self { states, outputs, definitions, sites, delays, signs, .. } = self;
        let delayed = delays.iter_mut().map(|delay| &mut delay.value);
        plant(states, outputs, definitions, sites, signs, delayed)
    }

    /// All expressions: those of the plant, limits of inputs, times of delays and those of the
    /// controller.
    pub fn expressions_mut(&mut self) -> Vec<&mut Expr> {
        let Self { inputs, states, outputs, definitions, sites, delays, signs, controller, .. } =
            self;
        let (delayed, times): (Vec<_>, Vec<_>) =
            delays.iter_mut().map(|Delay { value, time, .. }| (value, time)).unzip();
        let mut all = plant(states, outputs, definitions, sites, signs, delayed);
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
        self.fresh_name_besides(&Self::default(), wish)
    }

    /// The same, that another model does not have either.
    pub(crate) fn fresh_name_besides(&self, other: &Self, wish: &str) -> String {
        let taken: HashSet<&String> = self.names().into_iter().chain(other.names()).collect();
        first_free(wish, |name| taken.contains(name))
    }

    /// Every name, where it is declared or stands as a key.
    fn names(&self) -> Vec<&String> {
        every_name!(self, iter)
    }

    fn names_mut(&mut self) -> Vec<&mut String> {
        every_name!(self, iter_mut, mut)
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
    signs: &'a mut [Sign],
    delayed: impl IntoIterator<Item = &'a mut Expr>,
) -> Vec<&'a mut Expr> {
    let mut all: Vec<&mut Expr> = Vec::new();
    all.extend(states.iter_mut().map(|state| state.law.expr_mut()));
    all.extend(outputs.iter_mut().map(|output| &mut output.value));
    all.extend(definitions.iter_mut().map(|definition| &mut definition.value));
    all.extend(delayed);
    all.extend(signs.iter_mut().map(|sign| &mut sign.velocity));
    for site in sites {
        all.extend(site.enters.iter_mut().map(|(_, factor)| factor));
        all.extend(&mut site.position);
        all.extend(&mut site.velocity);
    }
    all
}
