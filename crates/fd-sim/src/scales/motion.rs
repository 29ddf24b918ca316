//! The motion at a site, as expressions of the model.

use std::collections::HashMap;

use super::{
    force::{ForceScale, is_discrete},
    parts::parts,
};
use crate::{
    equation::{Definitions, Expr, MAX_DEPTH, Size, Slopes},
    model::{Definition, FreshNames, Law, Model, Site},
};

/// Largest expression that definitions are written out in. What is larger goes through the names of
/// the definitions instead, with helpers for what the model does not define: the values are the same,
/// the text is longer for a person to follow.
const WRITTEN_OUT: Size = Size { nodes: 10_000, levels: MAX_DEPTH as u64 };

/// The quantities of one site that are probed.
#[derive(Clone, Debug)]
pub(super) struct SiteProbe {
    pub acceleration: Expr,
    pub compliance: Expr,
    /// What the acceleration is the sum of; none where it is too long for that, or a step in time.
    pub parts: Vec<Expr>,
    pub helpers: Vec<Definition>,
    pub velocity: Option<Expr>,
    pub position: Option<Expr>,
}

impl SiteProbe {
    pub(super) fn of_all(model: &Model) -> Vec<Self> {
        let mut names = FreshNames::of(model);
        model.sites.iter().map(|site| Self::of(model, site, &mut names)).collect()
    }

    fn of(model: &Model, site: &Site, names: &mut FreshNames) -> Self {
        let entered = match site.enters.as_slice() {
            [(state, _)] if site.velocity.is_none() && site.position.is_none() => {
                Some(Expr::name(state))
            }
            _ => None,
        };
        let velocity = site.velocity.clone().or(entered);
        // A store that a force fills is moved by it at once, whatever the file calls its rate.
        let filled = site.position.clone().filter(|position| is_filled(model, site, position));
        let moved = filled
            .or_else(|| velocity.clone())
            .or_else(|| site.position.clone())
            .or_else(|| site.enters.first().map(|(state, _)| Expr::name(state)))
            .unwrap_or(Expr::Number(0.0));
        let written = definitions(model).written_out(&moved, WRITTEN_OUT).and_then(|moved| {
            let slope = |state: &str| moved.differentiate(state).simplify();
            let [a, c] = motion(model, site, slope);
            (a.depth().max(c.depth()) <= MAX_DEPTH).then_some((a, c, Vec::new()))
        });
        let (acceleration, compliance, helpers) =
            written.unwrap_or_else(|| through_names(model, site, &moved, names));
        let balance = definitions(model).written_out(&acceleration, WRITTEN_OUT);
        let balance = balance.filter(|_| !is_discrete(model, site));
        let parts = balance.as_ref().map(parts).unwrap_or_default();
        let position = site.position.clone();
        Self { acceleration, compliance, parts, helpers, velocity, position }
    }
}

/// Whether the force changes the rate of the position, instead of that of a velocity.
fn is_filled(model: &Model, site: &Site, position: &Expr) -> bool {
    definitions(model).written_out(position, WRITTEN_OUT).is_some_and(|position| {
        let [_, filling] = motion(model, site, |state| position.differentiate(state).simplify());
        filling != Expr::Number(0.0)
    })
}

/// Acceleration and compliance, when `moved` has these slopes along the states.
fn motion(model: &Model, site: &Site, mut slope: impl FnMut(&str) -> Expr) -> [Expr; 2] {
    let mut acceleration = Expr::Number(0.0);
    let mut compliance = Expr::Number(0.0);
    for state in &model.states {
        let slope = slope(&state.name);
        let rate = match &state.law {
            Law::Derivative(law) => law.clone(),
            Law::Update(law) => law.clone() - Expr::name(&state.name),
        };
        acceleration = acceleration + slope.clone() * rate;
        for (_, factor) in site.enters.iter().filter(|(entered, _)| *entered == state.name) {
            compliance = compliance + slope.clone() * factor.clone();
        }
    }
    [acceleration.simplify(), compliance.simplify()]
}

/// The same by the chain rule: a helper for the slope of each definition along each state.
fn through_names(
    model: &Model,
    site: &Site,
    moved: &Expr,
    names: &mut FreshNames,
) -> (Expr, Expr, Vec<Definition>) {
    // Definitions of a checked model do not go round in circles.
    let in_order = definitions(model).in_order([moved]).unwrap_or_default();
    let mut helpers = Vec::new();
    let [acceleration, compliance] = motion(model, site, |state| {
        let called = |name: &str| names.take(&format!("{}_{name}_by_{state}", site.name));
        let slopes = Slopes::of(&in_order, state, called);
        let slope = slopes.slope(moved).unwrap_or(Expr::Number(0.0));
        helpers
            .extend(slopes.definitions.into_iter().map(|(name, value)| Definition { name, value }));
        slope
    });
    (acceleration, compliance, helpers)
}

impl ForceScale {
    /// The acceleration with all inputs at zero, and the helpers that it needs beside those of the
    /// site.
    #[must_use]
    pub fn unforced(&self, model: &Model) -> (Expr, Vec<Definition>) {
        let at_rest = |name: &str| {
            let is_input = model.inputs.iter().any(|input| input.name == name);
            is_input.then_some(Expr::Number(0.0))
        };
        let known = definitions(model);
        if self.helpers.is_empty()
            && let Some(written) = known.written_out(&self.acceleration, WRITTEN_OUT)
        {
            return (written.substitute(&at_rest).simplify(), Vec::new());
        }
        let own = self.helpers.iter().map(|helper| (helper.name.as_str(), &helper.value));
        let all = Definitions::new(pairs(model).chain(own));
        let known = self.helpers.iter().map(|helper| helper.name.clone());
        let mut names = FreshNames::of(model).besides(known);
        let mut unforced: HashMap<&str, String> = HashMap::new();
        let mut helpers = Vec::new();
        let replace = |unforced: &HashMap<&str, String>, expr: &Expr| {
            expr.substitute(&|name| at_rest(name).or_else(|| unforced.get(name).map(Expr::name)))
        };
        for (name, value) in all.in_order([&self.acceleration]).unwrap_or_default() {
            let changed = replace(&unforced, value);
            if changed != *value {
                let own = names.take(&format!("{}_{name}_unforced", self.name));
                helpers.push(Definition { name: own.clone(), value: changed });
                unforced.insert(name, own);
            }
        }
        (replace(&unforced, &self.acceleration).simplify(), helpers)
    }
}

fn pairs(model: &Model) -> impl Iterator<Item = (&str, &Expr)> {
    model.definitions.iter().map(|definition| (definition.name.as_str(), &definition.value))
}

fn definitions(model: &Model) -> Definitions<'_> {
    Definitions::new(pairs(model))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::equation::{Program, Scope};

    const SWING: &str = r#"
        version = 1
        kind = "equations"
        name = "swing"
        sample_time = 0.01
        parameters = { m = { unit = "kg", value = 2.0 }, l = { unit = "m", value = 0.7 } }
        inputs = { u = { unit = "N" } }
        outputs = { y = { unit = "rad", value = "q" } }
        [states]
        q = { unit = "rad", initial = 0.3, derivative = "w" }
        w = { unit = "rad/s", initial = -0.2, derivative = "(pull + u)/mass" }
        [definitions]
        mass = "m*l^2*(1 + 0.1*share)"
        share = "sin(q)*tip/l"
        tip = "w*l*cos(q) + 0.3*u"
        pull = "-share*abs(tip)"
        seen = "tip*share + exp(-share)"
        [sites]
        tip_force = { unit = "N", enters = { w = "l/mass" }, velocity = "seen" }
    "#;

    fn value(model: &Model, helpers: &[Definition], expr: &Expr, u: f64) -> f64 {
        let own = model.definitions.iter().chain(helpers);
        let scope = Scope {
            slow: vec!["m".into(), "l".into()],
            fast: vec!["q".into(), "w".into(), "u".into()],
            definitions: own.map(|d| (d.name.clone(), d.value.clone())).collect(),
            ..Scope::default()
        };
        let program = Program::compile(&scope, std::slice::from_ref(expr)).unwrap();
        let mut workspace = program.workspace::<f64>();
        workspace.slow_mut().copy_from_slice(&[2.0, 0.7]);
        program.prepare(&mut workspace);
        workspace.fast_mut().copy_from_slice(&[0.4, -1.3, u]);
        let mut result = [0.0];
        program.run(&mut workspace, &mut result);
        result[0]
    }

    #[test]
    fn written_out_and_through_names_are_the_same_numbers() {
        let model: Model = SWING.parse().unwrap();
        let site = &model.sites[0];
        let written = SiteProbe::of(&model, site, &mut FreshNames::of(&model));
        assert!(written.helpers.is_empty());
        let moved = site.velocity.clone().unwrap();
        let (acceleration, compliance, helpers) =
            through_names(&model, site, &moved, &mut FreshNames::of(&model));
        assert!(!helpers.is_empty());
        for (short, named) in
            [(&written.acceleration, &acceleration), (&written.compliance, &compliance)]
        {
            let [a, b] = [value(&model, &[], short, 0.9), value(&model, &helpers, named, 0.9)];
            // Some dozen operations in another order.
            assert!((a - b).abs() < 1e-13 * a.abs() && a != 0.0, "{a} {b}");
        }

        let scale = ForceScale {
            name: site.name.clone(),
            unit: site.unit.clone(),
            force: 1.0,
            mobility: 1.0,
            kick: 0.0,
            is_discrete: false,
            motion: super::super::SignalScale::of("", "", std::iter::empty()),
            acceleration,
            compliance,
            helpers,
            velocity: None,
            position: None,
        };
        let (unforced, more) = scale.unforced(&model);
        let helpers: Vec<Definition> = scale.helpers.iter().chain(&more).cloned().collect();
        let [a, b] = [
            value(&model, &[], &written.acceleration, 0.0),
            value(&model, &helpers, &unforced, 0.9),
        ];
        assert!((a - b).abs() < 1e-13 * a.abs() && a != 0.0, "{a} {b}");
    }
}
