//! The model of a shell.

use super::names::Names;
use crate::{
    equation::{Expr, is_name},
    model::{Definition, Draft, Input, Law, Model, ModelError, Output, Parameter, Site, State},
    simulate::Simulator,
};

/// A model that passes everything on, with its names.
pub(super) fn build(name: &str, inside: &dyn Simulator) -> Result<(Model, Names), ModelError> {
    let ts = inside.ts().seconds();
    let mut draft =
        Draft { name: name.to_owned(), sample_time: ts, step: Some(ts), ..Draft::default() };
    let mut names = Names::default();
    // Names that people read come first, so that what is added keeps clear of them.
    for channel in inside.outputs() {
        let (name, unit) = (free(&draft, &channel.name), unit(&channel.unit));
        let output = Output::new(name, unit, Expr::Number(0.0));
        draft.outputs.push(Output { wraps: channel.wraps, ..output });
    }
    for channel in inside.inputs() {
        let (name, unit) = (free(&draft, &channel.name), unit(&channel.unit));
        draft.inputs.push(Input { name, unit, saturation: None });
    }
    let lent = inside.parameters().len().saturating_sub(inside.natives().len());
    for parameter in &inside.parameters()[..lent] {
        let (name, unit) = (free(&draft, &parameter.name), unit(&parameter.unit));
        draft.parameters.push(Parameter { name, unit, ..parameter.clone() });
    }
    for i in 0..inside.inputs().len() {
        let Input { name, unit, .. } = draft.inputs[i].clone();
        let integral = integral(&draft, &format!("{name}_integral"), &unit, Expr::name(&name));
        names.integrals.push(integral.name.clone());
        draft.states.push(integral);
    }
    for port in inside.ports() {
        let (name, unit) = (free(&draft, &port.channel.name), unit(&port.channel.unit));
        let wish = format!("{name}_impulse");
        let enters = vec![(draft.fresh_name(&wish), Expr::Number(1.0))];
        names.impulses.push(enters[0].0.clone());
        draft.states.push(integral(&draft, &wish, &unit, Expr::Number(0.0)));
        draft.sites.push(Site { name, unit, enters, position: None, velocity: None });
    }
    for i in 0..draft.parameters.len() {
        let name = draft.parameters[i].name.clone();
        let inside = draft.fresh_name(&format!("{name}_inside"));
        names.handed_on.push(inside.clone());
        draft.definitions.push(Definition { name: inside, value: Expr::Name(name) });
    }
    for native in inside.natives() {
        let (wish, value) = (&native.parameter.name, native.parameter.value);
        let name = free(&draft, wish);
        draft.definitions.push(Definition { name: name.clone(), value: Expr::Number(value) });
        let inside = draft.fresh_name(&format!("{name}_inside"));
        draft.definitions.push(Definition { name: inside.clone(), value: Expr::name(&name) });
        names.handed_on.push(inside);
        names.resting.push((name, value));
    }
    for i in 0..draft.outputs.len() {
        let Output { name, unit, .. } = draft.outputs[i].clone();
        let raw = draft.fresh_name(&format!("{name}_raw"));
        draft.outputs[i].value = Expr::name(&raw);
        names.raw.push(raw.clone());
        draft.inputs.push(Input { name: raw, unit, saturation: None });
    }
    Ok((Model::try_from(draft)?, names))
}

/// A state that starts at 0 and adds up a rate.
fn integral(draft: &Draft, wish: &str, unit: &str, rate: Expr) -> State {
    let unit = if unit == "1" { "s".to_owned() } else { format!("({unit}) s") };
    let law = Law::Derivative(rate);
    State { name: draft.fresh_name(wish), unit, initial: 0.0, tolerance: None, law }
}

fn unit(unit: &str) -> String {
    if unit.trim().is_empty() { "1".to_owned() } else { unit.to_owned() }
}

/// A free name that can stand in an expression, as close to the wish as possible.
fn free(draft: &Draft, wish: &str) -> String {
    let allowed = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let mut name: String = wish.chars().map(allowed).collect();
    if !is_name(&name) {
        name = format!("x_{name}");
    }
    draft.fresh_name(&name)
}
