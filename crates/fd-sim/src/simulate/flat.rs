//! A model with its loop closed and its limits written out: one scope for all its expressions.

use crate::{
    equation::{Comparison, Cond, Expr, Scope, in_order_of_use},
    model::{Definition, Delay, Input, Law, Model},
};

/// Number of fast inputs before the states: `t` and `first`.
pub(super) const FIRST_STATE: usize = 2;

/// A model as the simulator sees it.
pub(super) struct Flat {
    /// Slow: parameters, then `dt`. Fast: `t`, `first`, states, external inputs, held control
    /// signals, signs, delayed values.
    pub scope: Scope,
    /// Rates of all states; zero for those with another law.
    pub rates: Vec<Expr>,
    /// Plant states with an update law, by index, and their laws.
    pub updates: Vec<(usize, Expr)>,
    /// Outputs.
    pub outputs: Vec<Expr>,
    /// Velocities of the signs.
    pub velocities: Vec<Expr>,
    /// Delayed expressions and their times, each after those that it uses.
    pub delays: Vec<(Expr, Expr)>,
    /// The sampled controller.
    pub control: Option<SampledControl>,
    pub states: usize,
    pub inputs: usize,
}

/// What happens when a sampled controller acts.
pub(super) struct SampledControl {
    /// Signals to be held, in the order of their fast inputs.
    pub signals: Vec<Expr>,
    /// Controller states, by index, and their laws.
    pub updates: Vec<(usize, Expr)>,
}

/// The name under which the value of an input before its saturation is known. It cannot clash: a
/// bar is not part of the language.
fn raw(name: &str) -> String {
    format!("{name}|raw")
}

/// Writes out a model. Inputs named in `last` come after all others.
pub(super) fn flatten(model: &Model, last: &[String]) -> Flat {
    let definition = |d: &Definition| (d.name.clone(), d.value.clone());
    let outputs: Vec<Expr> = model.outputs.iter().map(|output| output.value.clone()).collect();

    let mut scope = Scope {
        slow: model.parameters.iter().map(|parameter| parameter.name.clone()).collect(),
        fast: vec!["t".to_owned(), "first".to_owned()],
        definitions: model.definitions.iter().map(definition).collect(),
        tables: model.tables.iter().map(|t| (t.name.clone(), t.table.clone())).collect(),
    };
    scope.slow.push("dt".to_owned());
    scope.fast.extend(model.all_states().map(|state| state.name.clone()));
    scope.definitions.extend(model.outputs.iter().map(|o| (o.name.clone(), o.value.clone())));

    let external = model.external_inputs().into_iter().map(|channel| channel.name);
    let (at_the_end, others): (Vec<_>, Vec<_>) = external.partition(|name| last.contains(name));
    let inputs = others.len() + at_the_end.len();
    for name in others.into_iter().chain(at_the_end) {
        let limited = model.inputs.iter().find(|i| i.name == name && i.saturation.is_some());
        match limited {
            Some(input) => {
                scope.fast.push(raw(&name));
                scope.definitions.push((name.clone(), saturated(input, Expr::Name(raw(&name)))));
            }
            None => scope.fast.push(name),
        }
    }
    let control = close_the_loop(model, &mut scope);
    scope.fast.extend(model.signs.iter().map(|sign| sign.name.clone()));
    let velocities = model.signs.iter().map(|sign| sign.velocity.clone()).collect();
    let delays = hold_back(model, &mut scope);

    let mut rates = Vec::new();
    let mut updates = Vec::new();
    for (index, state) in model.all_states().enumerate() {
        match &state.law {
            Law::Derivative(expr) => rates.push(expr.clone()),
            Law::Update(expr) => {
                rates.push(Expr::Number(0.0));
                // Controller states come last and move when the controller acts.
                if index < model.states.len() {
                    updates.push((index, expr.clone()));
                }
            }
        }
    }
    let states = rates.len();
    Flat { scope, rates, updates, outputs, velocities, delays, control, states, inputs }
}

fn saturated(input: &Input, value: Expr) -> Expr {
    match &input.saturation {
        Some([low, high]) => Expr::clamp(value, low.clone(), high.clone()),
        None => value,
    }
}

/// Defines the driven inputs: by the signals of a continuous controller, by held values of a
/// sampled one.
fn close_the_loop(model: &Model, scope: &mut Scope) -> Option<SampledControl> {
    let controller = model.controller.as_ref()?;
    let definitions = controller.definitions.iter().map(|d| (d.name.clone(), d.value.clone()));
    scope.definitions.extend(definitions);
    let is_sampled = controller.sample_time.is_some();
    for signal in &controller.signals {
        let Some(input) = model.inputs.iter().find(|input| input.name == signal.input) else {
            continue; // the model was checked
        };
        let value = if is_sampled {
            scope.fast.push(raw(&input.name));
            Expr::Name(raw(&input.name))
        } else {
            signal.value.clone()
        };
        scope.definitions.push((input.name.clone(), saturated(input, value)));
    }
    let updates = controller.states.iter().enumerate();
    is_sampled.then(|| SampledControl {
        signals: controller.signals.iter().map(|signal| signal.value.clone()).collect(),
        updates: updates.map(|(i, s)| (model.states.len() + i, s.law.expr().clone())).collect(),
    })
}

/// Defines delayed values as fast inputs, or as the expression itself where the delay is zero.
fn hold_back(model: &Model, scope: &mut Scope) -> Vec<(Expr, Expr)> {
    let named: Vec<(&str, &Expr)> = (model.delays.iter().map(|d| (d.name.as_str(), &d.value)))
        .chain(scope.definitions.iter().map(|(name, value)| (name.as_str(), value)))
        .collect();
    let roots: Vec<Expr> = model.delays.iter().map(|delay| Expr::name(&delay.name)).collect();
    // Definitions of a checked model do not go round in circles.
    let order = in_order_of_use(&named, &roots).unwrap_or_default();
    let in_order: Vec<&Delay> = order.into_iter().filter_map(|i| model.delays.get(i)).collect();

    for delay in &in_order {
        let held = format!("{}|held", delay.name);
        scope.fast.push(held.clone());
        let is_late = Cond::compare(Comparison::Greater, delay.time.clone(), Expr::Number(0.0));
        let value = Expr::choice(is_late, Expr::Name(held), delay.value.clone());
        scope.definitions.push((delay.name.clone(), value));
    }
    in_order.into_iter().map(|delay| (delay.value.clone(), delay.time.clone())).collect()
}
