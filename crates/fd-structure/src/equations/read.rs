//! From the entries of a model file to equations.

use std::collections::HashSet;

use fd_sim::{
    equation::{Expr, Unary},
    model::{Definition, Input, Law, Model, State},
};

use super::{EquationModel, Relation, error::EquationsError, faults::FaultPlaces, logged};
use crate::model::{Builder, StructuralModel};

impl EquationModel {
    /// Reads the equations of a model, with faults at these places.
    ///
    /// # Errors
    ///
    /// Returns an error for faults at places that the model does not have.
    pub fn new(model: &Model, places: &FaultPlaces) -> Result<Self, EquationsError> {
        read(model, places)
    }
}

fn read(model: &Model, places: &FaultPlaces) -> Result<EquationModel, EquationsError> {
    let (unknowns, constants) = sorted(model);
    let mut reader = Reader {
        builder: StructuralModel::builder(&model.name),
        relations: Vec::new(),
        unknowns,
        written: HashSet::new(),
    };
    for input in model.inputs.iter().filter(|input| !model.is_driven(&input.name)) {
        let value = saturated(input, Expr::Name(logged(&input.name)));
        reader.equal(format!("input {}", input.name), Expr::name(&input.name), value, false);
    }
    for state in &model.states {
        reader.state(state, false, state.law.expr().clone());
    }
    for definition in &model.definitions {
        reader.definition(definition, definition.value.clone(), false);
    }
    for delay in &model.delays {
        let now = format!("now {}", delay.name);
        reader.equal(
            format!("undelayed {}", delay.name),
            Expr::name(&now),
            delay.value.clone(),
            false,
        );
        reader.dynamic(format!("delay {}", delay.name), &delay.name, &now, Relation::Delay);
    }
    for sign in &model.signs {
        let value = Expr::unary(Unary::Sign, sign.velocity.clone());
        reader.equal(format!("sign {}", sign.name), Expr::name(&sign.name), value, false);
    }
    reader.controller(model);
    for output in &model.outputs {
        let log = Expr::Name(logged(&output.name));
        reader.equal(format!("sensor {}", output.name), log, output.value.clone(), false);
    }

    let mut builder = reader.builder;
    let is_there = |equation: &String| reader.written.contains(equation);
    // A definition that is a constant has no equation that could break.
    let faults = places.of(model)?.into_iter().filter(|(_, equation)| is_there(equation));
    for (fault, equation) in faults {
        builder = builder.fault(fault, equation);
    }
    Ok(EquationModel {
        structure: builder.build()?,
        relations: reader.relations,
        source: model.clone(),
        constants,
    })
}

/// Names of the unknowns, and the definitions that need none.
fn sorted(model: &Model) -> (HashSet<String>, Vec<(String, Expr)>) {
    let inputs = model.inputs.iter().map(|input| input.name.clone());
    let states = model.all_states().map(|state| state.name.clone());
    let delays = model.delays.iter().map(|delay| delay.name.clone());
    let signs = model.signs.iter().map(|sign| sign.name.clone());
    let mut unknowns: HashSet<String> = inputs.chain(states).chain(delays).chain(signs).collect();
    // The controller sees the log.
    let controller = model.controller.iter();
    let references = controller.flat_map(|controller| &controller.references).map(|r| &r.name);
    let outputs = model.outputs.iter().map(|output| &output.name);
    let logged: HashSet<&String> = references.chain(outputs).collect();

    let of_controller = model.controller.iter().flat_map(|controller| &controller.definitions);
    let mut rest: Vec<&Definition> = model.definitions.iter().chain(of_controller).collect();
    loop {
        let before = rest.len();
        rest.retain(|definition| {
            let mut varies = false;
            definition.value.visit_names(&mut |name| {
                varies |= unknowns.contains(name) || logged.contains(&name.to_owned());
            });
            if varies {
                unknowns.insert(definition.name.clone());
            }
            !varies
        });
        if rest.len() == before {
            let constants = rest.into_iter().map(|d| (d.name.clone(), d.value.clone())).collect();
            return (unknowns, constants);
        }
    }
}

fn saturated(input: &Input, value: Expr) -> Expr {
    match &input.saturation {
        Some([low, high]) => Expr::clamp(value, low.clone(), high.clone()),
        None => value,
    }
}

struct Reader {
    builder: Builder,
    relations: Vec<Relation>,
    unknowns: HashSet<String>,
    /// Names of the equations.
    written: HashSet<String>,
}

impl Reader {
    fn equal(&mut self, name: String, left: Expr, right: Expr, is_sampled: bool) {
        let (mut unknowns, mut knowns) = (Vec::new(), Vec::new());
        if let Expr::Name(name) = &left
            && !name.starts_with("log.")
        {
            unknowns.push(name.clone());
        }
        for side in [&left, &right] {
            side.visit_names(&mut |name| {
                if let Some(signal) = name.strip_prefix("log.") {
                    knowns.push(signal.to_owned());
                } else if self.unknowns.contains(name) {
                    unknowns.push(name.to_owned());
                }
            });
        }
        knowns.dedup();
        // Signals have names of their own, apart from the unknowns.
        let knowns: Vec<String> = knowns.iter().map(|signal| logged(signal)).collect();
        self.written.insert(name.clone());
        self.builder = std::mem::take(&mut self.builder).equation(
            name,
            unknowns.iter().map(String::as_str),
            knowns.iter().map(String::as_str),
        );
        self.relations.push(if is_sampled {
            Relation::Sampled { left, right }
        } else {
            Relation::Equal { left, right }
        });
    }

    fn dynamic(&mut self, name: String, state: &str, rate: &str, relation: Relation) {
        self.written.insert(name.clone());
        self.builder = std::mem::take(&mut self.builder).dynamic(name, state, rate);
        self.relations.push(relation);
    }

    fn state(&mut self, state: &State, is_sampled: bool, law: Expr) {
        let (name, initial) = (&state.name, state.initial);
        let (rate, constraint, relation) = match state.law {
            Law::Derivative(_) => {
                (format!("{name}'"), format!("d/dt {name}"), Relation::Derivative { initial })
            }
            Law::Update(_) => {
                (format!("{name}+"), format!("next {name}"), Relation::Update { initial })
            }
        };
        self.equal(format!("law {name}"), Expr::name(&rate), law, is_sampled);
        self.dynamic(constraint, name, &rate, relation);
    }

    fn definition(&mut self, definition: &Definition, value: Expr, is_sampled: bool) {
        if self.unknowns.contains(&definition.name) {
            let name = format!("definition {}", definition.name);
            self.equal(name, Expr::name(&definition.name), value, is_sampled);
        }
    }

    /// What a controller computes, from the log of what it measures.
    fn controller(&mut self, model: &Model) {
        let Some(controller) = &model.controller else { return };
        let seen = |name: &str| {
            let is_output = model.outputs.iter().any(|output| output.name == name);
            let is_reference = controller.references.iter().any(|r| r.name == name);
            (is_output || is_reference).then(|| Expr::Name(logged(name)))
        };
        let is_sampled = controller.sample_time.is_some();
        for state in &controller.states {
            self.state(state, is_sampled, state.law.expr().substitute(&seen));
        }
        for definition in &controller.definitions {
            self.definition(definition, definition.value.substitute(&seen), is_sampled);
        }
        for signal in &controller.signals {
            let Some(input) = model.inputs.iter().find(|input| input.name == signal.input) else {
                continue; // the model was checked
            };
            let value = saturated(input, signal.value.substitute(&seen));
            let name = format!("control {}", input.name);
            self.equal(name, Expr::name(&input.name), value, is_sampled);
        }
    }
}
