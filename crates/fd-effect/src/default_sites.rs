//! Sites of forces for a model that names none.

use fd_sim::{
    equation::Expr,
    model::{Draft, Law, Model, Site, State},
};

use super::units::per;

/// The model with a site at every state equation that no site of the model enters, so that effects
/// of the dynamics can be tried there. Simulations do not change.
///
/// The "force" is a rate, in the unit of the state per second: `v' = … + force`. Where another
/// state is nothing but the integral of this one, as `x' = v`, it is the position of the site and
/// gets no site of its own.
///
/// ```
/// use fd_effect::with_default_sites;
/// use fd_sim::model::Model;
///
/// let model: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "slider"
/// sample_time = 0.01
/// inputs = { u = { unit = "m/s^2" } }
/// outputs = { y = { unit = "m", value = "x" } }
/// [states]
/// x = { unit = "m", initial = 0.0, derivative = "v" }
/// v = { unit = "m/s", initial = 0.0, derivative = "u" }
/// "#.parse()?;
/// let model = with_default_sites(&model);
/// assert_eq!(model.sites.len(), 1);
/// assert_eq!(model.sites[0].name, "v_equation");
/// assert_eq!(model.sites[0].unit, "m/s^2");
/// # Ok::<(), fd_sim::model::ModelError>(())
/// ```
#[must_use]
pub fn with_default_sites(model: &Model) -> Model {
    let mut draft = model.clone().into_draft();
    for state in &model.states {
        let is_entered = |site: &Site| site.enters.iter().any(|(name, _)| *name == state.name);
        let is_free = !model.sites.iter().any(is_entered) && integrates(model, state).is_none();
        if matches!(state.law, Law::Derivative(_)) && is_free {
            let site = site_of(model, &draft, state);
            draft.sites.push(site);
        }
    }
    // Fresh names of sites that enter known states make a correct model.
    Model::try_from(draft).unwrap_or_else(|_| model.clone())
}

fn site_of(model: &Model, draft: &Draft, state: &State) -> Site {
    let is_position =
        |other: &&State| integrates(model, other).is_some_and(|of| of.name == state.name);
    let position = model.states.iter().find(is_position);
    Site {
        name: draft.fresh_name(&format!("{}_equation", state.name)),
        unit: match state.unit.strip_suffix("/s") {
            Some(unit) => per(unit, "s^2"),
            None => per(&state.unit, "s"),
        },
        enters: vec![(state.name.clone(), Expr::Number(1.0))],
        position: position.map(|position| Expr::name(&position.name)),
        velocity: position.map(|_| Expr::name(&state.name)),
    }
}

/// The state of which this one is nothing but the integral.
fn integrates<'a>(model: &'a Model, state: &State) -> Option<&'a State> {
    let Law::Derivative(Expr::Name(rate)) = &state.law else { return None };
    model.states.iter().find(|known| known.name == *rate && known.name != state.name)
}
