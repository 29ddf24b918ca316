//! The part of a model that some expressions need.

use std::collections::HashSet;

use crate::{
    equation::Expr,
    model::{Draft, Law, Output},
};

/// A draft with these outputs and states, what they need, all inputs and all parameters. The order
/// of everything stays.
pub(super) fn prune(model: &Draft, outputs: Vec<Output>, states: &[&str]) -> Draft {
    let mut needed: HashSet<&str> = states.iter().copied().collect();
    let kept = model.states.iter().filter(|state| needed.contains(state.name.as_str()));
    let roots = kept.map(|state| state.law.expr()).chain(outputs.iter().map(|o| &o.value));
    let mut open: Vec<&Expr> = roots.collect();
    while let Some(expr) = open.pop() {
        expr.visit_names(&mut |name| {
            if let Some((name, more)) = meaning(model, name)
                && needed.insert(name)
            {
                open.extend(more);
            }
        });
    }
    let mut draft = Draft { sites: Vec::new(), controller: None, ..model.clone() };
    draft.states.retain(|state| needed.contains(state.name.as_str()));
    draft.definitions.retain(|definition| needed.contains(definition.name.as_str()));
    draft.delays.retain(|delay| needed.contains(delay.name.as_str()));
    draft.signs.retain(|sign| needed.contains(sign.name.as_str()));
    draft.outputs = outputs;
    draft
}

/// The entry of that name, unless it is a parameter or an input, and the expressions it consists of.
fn meaning<'a>(model: &'a Draft, name: &str) -> Option<(&'a str, Vec<&'a Expr>)> {
    let state = model.states.iter().find(|state| state.name == name);
    let definition = model.definitions.iter().find(|definition| definition.name == name);
    let delay = model.delays.iter().find(|delay| delay.name == name);
    let sign = model.signs.iter().find(|sign| sign.name == name);
    state
        .map(|state| (state.name.as_str(), vec![state.law.expr()]))
        .or_else(|| definition.map(|d| (d.name.as_str(), vec![&d.value])))
        .or_else(|| delay.map(|d| (d.name.as_str(), vec![&d.value])))
        .or_else(|| sign.map(|s| (s.name.as_str(), vec![&s.velocity])))
}

/// Whether an expression has one value all through an integration step, given inputs that are held:
/// neither time nor a state with a derivative is in it. A delayed value of what is held is the mean over the step.
pub(super) fn is_held(model: &Draft, expr: &Expr) -> bool {
    let mut is_held = true;
    expr.visit_names(&mut |name| {
        let state = model.states.iter().find(|state| state.name == name);
        let definition = model.definitions.iter().find(|definition| definition.name == name);
        let delay = model.delays.iter().find(|delay| delay.name == name);
        let moves = state.is_some_and(|state| matches!(state.law, Law::Derivative(_)))
            || definition.is_some_and(|definition| !self::is_held(model, &definition.value))
            || delay.is_some_and(|delay| !self::is_held(model, &delay.value));
        is_held &= name != "t" && !moves;
    });
    is_held
}
