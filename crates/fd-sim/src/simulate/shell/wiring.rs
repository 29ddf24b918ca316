//! The work of a patched shell before and after a step of the simulator inside.

use super::{
    names::Names,
    prune::{is_held, prune},
};
use crate::{
    equation::{Expr, Program, Scope},
    model::{Law, Model, Output},
    simulate::SimulateError,
};

/// A patched shell, taken apart. Models of its parts have all parameters and inputs of the shell.
#[derive(Clone, Debug)]
pub(super) struct Wiring {
    /// Parameters of the simulator inside, from those of the shell.
    pub parameters: Program,
    /// What the inputs inside are.
    pub inputs: Vec<Source>,
    /// What the forces inside are.
    pub forces: Vec<Source>,
    /// Where these come from, unless all of them are passed on.
    pub before: Option<Model>,
    /// Whether `before` depends on raw outputs.
    pub needs_outputs: bool,
    /// What the sensors make of the raw outputs, unless these are passed on.
    pub after: Option<Model>,
}

/// Where the mean of a signal over a step comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Source {
    /// There is none.
    Zero,
    /// An input from outside.
    Input(usize),
    /// An output of the part before.
    Output(usize),
    /// The increment of that state of the part before, divided by the step.
    Increment(String),
}

impl Wiring {
    pub(super) fn new(model: &Model, names: &Names) -> Result<Self, SimulateError> {
        let raw = model.inputs.iter().skip(names.integrals.len()).map(|input| &input.name);
        if !raw.eq(&names.raw) || model.outputs.len() != names.raw.len() {
            return Err(missing("raw outputs", &names.raw.join("`, `")));
        }
        let inputs: Vec<_> =
            names.integrals.iter().map(|name| rate(model, name)).collect::<Result<_, _>>()?;
        let forces: Vec<_> =
            names.impulses.iter().map(|name| rate(model, name)).collect::<Result<_, _>>()?;

        let mut before = Before { model, outputs: Vec::new(), states: Vec::new() };
        let inputs: Vec<Source> =
            inputs.into_iter().map(|(state, rate)| before.source(state, rate)).collect();
        let forces: Vec<Source> =
            forces.into_iter().map(|(state, rate)| before.source(state, rate)).collect();
        let before = before.finish()?;
        let mentions = |model: &Model, raw: &String| {
            let mut draft = model.clone().into_draft();
            draft.plant_expressions_mut().iter().any(|expr| expr.mentions(raw))
        };
        Ok(Self {
            parameters: parameters(model, names)?,
            inputs,
            forces,
            needs_outputs: before
                .as_ref()
                .is_some_and(|before| names.raw.iter().any(|raw| mentions(before, raw))),
            before,
            after: after(model, names)?,
        })
    }
}

fn missing(what: &'static str, name: &str) -> SimulateError {
    SimulateError::NotThisShell { what, name: name.to_owned() }
}

/// The state of that name, and what it integrates.
fn rate<'a>(model: &'a Model, name: &'a str) -> Result<(&'a str, &'a Expr), SimulateError> {
    let state = model.states.iter().find(|state| state.name == name);
    match state.map(|state| &state.law) {
        Some(Law::Derivative(rate)) => Ok((name, rate)),
        _ => Err(missing("integral", name)),
    }
}

/// The part before, in the making.
struct Before<'a> {
    model: &'a Model,
    outputs: Vec<Output>,
    /// States that integrate.
    states: Vec<&'a str>,
}

impl<'a> Before<'a> {
    /// The source of a signal of which `state` is the integral.
    fn source(&mut self, state: &'a str, rate: &'a Expr) -> Source {
        let input = |name: &String| self.model.inputs.iter().position(|i| i.name == *name);
        match rate {
            Expr::Number(0.0) => Source::Zero,
            Expr::Name(name) if input(name).is_some() => {
                input(name).map_or(Source::Zero, Source::Input)
            }
            rate if is_held(self.model, rate) => {
                self.outputs.push(shown(state, rate));
                Source::Output(self.outputs.len() - 1)
            }
            _ => {
                self.states.push(state);
                Source::Increment(state.to_owned())
            }
        }
    }
}

impl Before<'_> {
    fn finish(self) -> Result<Option<Model>, SimulateError> {
        let Self { model, mut outputs, states } = self;
        if outputs.is_empty() && states.is_empty() {
            return Ok(None);
        }
        if outputs.is_empty() {
            // A model needs an output.
            outputs.push(shown("nothing", &Expr::Number(0.0)));
        }
        let mut draft = prune(model, outputs, &states);
        // Names that nothing else has.
        for i in 0..draft.outputs.len() {
            draft.outputs[i].name = draft.fresh_name(&format!("held_{}", i + 1));
        }
        Ok(Some(Model::try_from(draft)?))
    }
}

fn shown(name: &str, value: &Expr) -> Output {
    Output::new(name, "1", value.clone())
}

/// The outputs, unless all are passed on.
fn after(model: &Model, names: &Names) -> Result<Option<Model>, SimulateError> {
    let is_raw = |(output, raw): (&Output, &String)| output.value == Expr::name(raw);
    if model.outputs.iter().zip(&names.raw).all(is_raw) {
        return Ok(None);
    }
    Ok(Some(Model::try_from(prune(model, model.outputs.clone(), &[]))?))
}

fn parameters(model: &Model, names: &Names) -> Result<Program, SimulateError> {
    let definition = |d: &crate::model::Definition| (d.name.clone(), d.value.clone());
    let scope = Scope {
        slow: model.parameters.iter().map(|parameter| parameter.name.clone()).collect(),
        fast: Vec::new(),
        definitions: model.definitions.iter().map(definition).collect(),
        tables: model.tables.iter().map(|t| (t.name.clone(), t.table.clone())).collect(),
    };
    // Equations that were written before the simulator had an effect leave it at rest.
    let lent = names.handed_on.len() - names.resting.len();
    let handed_on = names.handed_on.iter().enumerate().map(|(i, name)| match i.checked_sub(lent) {
        Some(i) if !model.definitions.iter().any(|known| known.name == *name) => {
            Expr::Number(names.resting[i].1)
        }
        _ => Expr::name(name),
    });
    let handed_on: Vec<Expr> = handed_on.collect();
    Ok(Program::compile(&scope, &handed_on)?)
}
