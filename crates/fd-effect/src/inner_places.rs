//! Signals inside a model as places for effects.

use std::sync::Arc;

use fd_sim::{
    equation::{Binary, Expr, Unary},
    model::{Definition, Draft, Law, Model},
};

/// The model with a name for every term of a sum in a derivative, so that effects can be tried there:
/// `v' = (force - d*v)/m` becomes `v' = (force - v_term_1)/m` with `v_term_1 = d*v`. Numbers, parameters and bare
/// names are no places of their own: they are inputs, states or definitions, which are known. Equal terms are
/// one signal. Simulations do not change.
///
/// ```
/// use fd_effect::with_inner_places;
/// use fd_sim::model::Model;
///
/// let model: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "slider"
/// sample_time = 0.01
/// parameters = { m = { unit = "kg", value = 2.0 }, d = { unit = "N s/m", value = 1.0 } }
/// inputs = { force = { unit = "N" } }
/// states = { v = { unit = "m/s", initial = 0.0, derivative = "(force - d*v)/m" } }
/// outputs = { y = { unit = "m/s", value = "v" } }
/// "#.parse()?;
/// let model = with_inner_places(&model);
/// assert_eq!(model.definitions[0].name, "v_term_1");
/// assert_eq!(model.definitions[0].value.to_string(), "d*v");
/// assert_eq!(model.states[0].law.expr().to_string(), "(force - v_term_1)/m");
/// # Ok::<(), fd_sim::model::ModelError>(())
/// ```
#[must_use]
pub fn with_inner_places(model: &Model) -> Model {
    let mut draft = model.clone().into_draft();
    let states: Vec<(String, Law)> =
        model.states.iter().map(|state| (state.name.clone(), state.law.clone())).collect();
    for (place, (name, law)) in states.into_iter().enumerate() {
        if let Law::Derivative(expr) = law {
            let mut count = 0;
            let named = with_named_terms(&expr, false, &mut |term| {
                count += 1;
                named(&mut draft, &format!("{name}_term_{count}"), term)
            });
            draft.states[place].law = Law::Derivative(named);
        }
    }
    // Fresh names for parts of correct equations make a correct model.
    Model::try_from(draft).unwrap_or_else(|_| model.clone())
}

/// The name of a term: that of a definition which is the same, as of a flow that leaves one store and enters
/// another, or a new one like this.
fn named(draft: &mut Draft, wish: &str, term: &Expr) -> Expr {
    if let Some(known) = draft.definitions.iter().find(|known| known.value == *term) {
        return Expr::name(&known.name);
    }
    let name = draft.fresh_name(wish);
    draft.definitions.push(Definition { name: name.clone(), value: term.clone() });
    Expr::name(name)
}

/// The expression with the terms of its sums replaced; sums below factors and quotients count as well.
fn with_named_terms(expr: &Expr, is_term: bool, name: &mut dyn FnMut(&Expr) -> Expr) -> Expr {
    match expr {
        Expr::Binary(op @ (Binary::Add | Binary::Sub), a, b) => {
            let (a, b) = (with_named_terms(a, true, name), with_named_terms(b, true, name));
            Expr::Binary(*op, Arc::new(a), Arc::new(b))
        }
        Expr::Unary(Unary::Neg, inner) => {
            Expr::Unary(Unary::Neg, Arc::new(with_named_terms(inner, is_term, name)))
        }
        Expr::Binary(op @ (Binary::Mul | Binary::Div), a, b) if is_sum(a) || is_sum(b) => {
            let part = |part: &Expr, name: &mut dyn FnMut(&Expr) -> Expr| {
                if is_sum(part) { with_named_terms(part, false, name) } else { part.clone() }
            };
            let (a, b) = (part(a, name), part(b, name));
            Expr::Binary(*op, Arc::new(a), Arc::new(b))
        }
        Expr::Number(_) | Expr::Name(_) => expr.clone(),
        _ if is_term => name(expr),
        _ => expr.clone(),
    }
}

fn is_sum(expr: &Expr) -> bool {
    match expr {
        Expr::Binary(Binary::Add | Binary::Sub, ..) => true,
        Expr::Unary(Unary::Neg, inner) => is_sum(inner),
        Expr::Binary(Binary::Mul | Binary::Div, a, b) => is_sum(a) || is_sum(b),
        _ => false,
    }
}
