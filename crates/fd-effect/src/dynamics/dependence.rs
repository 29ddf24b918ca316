//! A parameter that follows a signal of the log.

use std::collections::BTreeSet;

use fd_sim::{
    equation::{Binary, Expr, Unary},
    model::{Draft, Model},
    scales::{ReplayScales, SignalScale},
};

use super::parameter::is_used;
use crate::{Effect, NotTestable, Offers, Reason, SiteRef, Sketch, units::per};

/// What is left of a parameter at least, as a part of it: its sign is kept beyond the range of the log.
const LEAST: f64 = 0.05;
/// Largest exponent of the curve: the same part, and its inverse.
const MOST: f64 = 3.0;
/// Terms of a sum that are looked at; models of people have a dozen.
const MOST_TERMS: usize = 200;

/// A parameter that depends on another channel `s` of the log, `p (1 + a (s - S))` with the mean `S` of the channel in the log:
/// a resistance on a temperature, a heat transfer on a fan, a gain on the voltage of the supply. The law `curve` is
/// `p exp(a (s - S) + b ((s - S)/d)²)`, with `d` the largest deviation: powers and exponentials are near to it. It never falls below
/// a twentieth of `p`, and the curve never rises above twenty times that.
///
/// Tried with every input, those included that nothing else in the model uses, and with every output that is not the motion
/// of a site: what depends on a motion is a friction or a spring. Outputs are taken as simulated, so that their noise does not
/// matter. Where nothing but the signal stands beside the parameter, the dependence is a curve of the signal, which has laws of
/// its own, and is not tried.
#[derive(Clone, Copy, Debug)]
pub struct ParameterDependence;

impl Effect for ParameterDependence {
    fn label(&self) -> &'static str {
        "parameter-dependence"
    }

    fn family(&self) -> &'static str {
        "parameter"
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let drivers = drivers(nominal, scales);
        let each = nominal.parameters.iter().enumerate().flat_map(|(i, parameter)| {
            let refuse = |sketch: Sketch<'_>| -> Option<NotTestable> {
                // A black box takes its parameters when it starts.
                let sketch = sketch
                    .require(!scales.states.is_empty(), Reason::Missing("state"))
                    .require(parameter.tolerance > 0.0, Reason::Exact)
                    .require(is_used(nominal, parameter), Reason::Unused)
                    .require(!drivers.is_empty(), Reason::Alone("signal"));
                sketch.start(&[]).finish().err()
            };
            let sketch = |law| Sketch::of_parameter(self, law, nominal, scales, i);
            if let Some(refused) = refuse(sketch("linear")) {
                return vec![Err(refused)];
            }
            let partners = partners_of(nominal, &parameter.name);
            let open = drivers.iter().filter(|driver| !driver.is_alone_in(&partners));
            let laws = open.flat_map(|driver| {
                let follows = |law| driver.followed(sketch(law));
                [
                    follows("linear").wrap_parameter("p*max(1 + a*(s - S), least)").start(&[0.05]),
                    follows("curve")
                        .strength("b", &format!("bend_with_{}", driver.name), "1", 1.0, [-2.0, 2.0])
                        // Beyond the range of the log it stays bent as at its end.
                        .abbreviate("q", "clamp((s - S)/d, -1, 1)")
                        .bind("most", MOST)
                        .wrap_parameter("p*exp(clamp(a*(s - S) + b*q^2, -most, most))")
                        .starts([[0.05, 0.02], [0.05, -0.02]]),
                ]
                .map(Sketch::finish)
            });
            laws.collect::<Offers>()
        });
        each.collect()
    }
}

/// A signal that a parameter may follow.
struct Driver<'a> {
    site: SiteRef,
    name: &'a str,
    value: Expr,
    variables: BTreeSet<&'a str>,
    scale: &'a SignalScale,
}

/// Inputs and outputs of the log that move; no outputs that show the motion of a site.
fn drivers<'a>(nominal: &'a Model, scales: &'a ReplayScales) -> Vec<Driver<'a>> {
    let driver = |site, name, value, scale| {
        let variables = variables(nominal, &value);
        Driver { site, name, value, variables, scale }
    };
    let inputs =
        nominal.inputs.iter().zip(&scales.inputs).enumerate().map(|(j, (input, scale))| {
            let site = SiteRef::Input(j, input.name.clone());
            driver(site, &input.name, Expr::name(&input.name), scale)
        });
    let moving = moving_states(nominal);
    let shows_motion = |value: &Expr| !variables(nominal, value).is_disjoint(&moving);
    let outputs = nominal.outputs.iter().zip(&scales.outputs).enumerate();
    let outputs = outputs.filter(|(_, (output, _))| !shows_motion(&output.value));
    let outputs = outputs.map(|(j, (output, scale))| {
        let site = SiteRef::Output(j, output.name.clone());
        driver(site, &output.name, output.value.clone(), scale)
    });
    // Without a state it is an input, in whatever unit.
    let is_of_state = |driver: &Driver<'_>| {
        nominal.states.iter().any(|state| driver.variables.contains(state.name.as_str()))
    };
    let outputs = outputs.filter(is_of_state);
    inputs.chain(outputs).filter(|driver| driver.scale.moves()).collect()
}

/// States of a motion: in the position or velocity that a site names, or one the rate of the other, and their integrals.
fn moving_states(model: &Model) -> BTreeSet<&str> {
    let named = model.sites.iter().flat_map(|site| [&site.velocity, &site.position]).flatten();
    let mut moving: BTreeSet<&str> = named.flat_map(|motion| variables(model, motion)).collect();
    for state in &model.states {
        let rate = state.law.expr();
        let is_of_state = model.states.iter().any(|other| *rate == Expr::name(&other.name));
        let rates = variables(model, rate);
        if is_of_state || (!rates.is_empty() && rates.is_subset(&moving)) {
            moving.insert(&state.name);
            moving.extend(rates);
        }
    }
    moving
}

impl Driver<'_> {
    /// Largest deviation from the mean.
    fn deviation(&self) -> f64 {
        let SignalScale { mean, low, high, .. } = self.scale;
        (high - mean).max(mean - low)
    }

    /// Adds the dependence `a` on the signal `s`.
    fn followed<'a>(&self, sketch: Sketch<'a>) -> Sketch<'a> {
        let deviation = self.deviation();
        let unit = per("1", &self.scale.unit);
        sketch
            .partner(self.site.clone())
            .bind("s", self.value.clone())
            .bind("S", self.scale.mean)
            .bind("d", deviation)
            .bind("least", LEAST)
            .strength("a", &format!("per_{}", self.name), unit, 1.0 / deviation, [-0.95, 2.0])
    }

    /// Whether nothing else stands beside the parameter in any term: then the dependence is a curve of the signal.
    fn is_alone_in(&self, partners: &[BTreeSet<&str>]) -> bool {
        let is_own = |names: &BTreeSet<&str>| names.is_subset(&self.variables);
        partners.iter().any(|names| !names.is_empty()) && partners.iter().all(is_own)
    }
}

/// The states and inputs that stand in one term of a sum with a parameter, for all such terms of the plant: products and
/// quotients of sums are multiplied out.
fn partners_of<'m>(model: &'m Model, parameter: &str) -> Vec<BTreeSet<&'m str>> {
    let mut draft: Draft = model.clone().into_draft();
    let mut open: Vec<Expr> =
        draft.plant_expressions_mut().into_iter().map(|expr| expr.clone()).collect();
    let mut partners = Vec::new();
    while let Some(expr) = open.pop().filter(|_| partners.len() < MOST_TERMS) {
        match split(&expr) {
            Some(parts) => open.extend(parts),
            None if expr.mentions(parameter) => partners.push(variables(model, &expr)),
            None => {}
        }
    }
    partners
}

/// The two terms of a sum, or of what a sum is multiplied with or divided by.
fn split(expr: &Expr) -> Option<[Expr; 2]> {
    match expr {
        Expr::Binary(Binary::Add | Binary::Sub, a, b) => Some([(**a).clone(), (**b).clone()]),
        Expr::Binary(Binary::Mul, a, b) => {
            let product = |parts: [Expr; 2], by: &Expr| parts.map(|part| part * by.clone());
            split(a)
                .map(|parts| product(parts, b))
                .or_else(|| split(b).map(|parts| product(parts, a)))
        }
        Expr::Binary(Binary::Div, a, b) => {
            split(a).map(|parts| parts.map(|part| part / (**b).clone()))
        }
        Expr::Unary(Unary::Neg, a) => split(a),
        _ => None,
    }
}

/// The states and inputs that an expression depends on.
pub(super) fn variables<'m>(model: &'m Model, expr: &Expr) -> BTreeSet<&'m str> {
    let known = model.states.iter().map(|state| &state.name);
    let known: Vec<&String> = known.chain(model.inputs.iter().map(|input| &input.name)).collect();
    let (mut found, mut seen, mut open) = (BTreeSet::new(), BTreeSet::new(), vec![expr]);
    while let Some(expr) = open.pop() {
        found.extend(known.iter().filter(|name| expr.mentions(name)).map(|name| name.as_str()));
        let new = model.definitions.iter().filter(|definition| expr.mentions(&definition.name));
        open.extend(new.filter(|new| seen.insert(new.name.as_str())).map(|new| &new.value));
    }
    found
}
