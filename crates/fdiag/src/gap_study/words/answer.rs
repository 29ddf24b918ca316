//! Causes, with their places and strengths.

use fd_effect::{Side, SiteRef};
use fd_gap::diagnose::{Cause, Estimate, Group, Pair};

use fd_sim::equation::Expr;

use super::{
    labels::{at, family, label, site},
    numbers::{with_error, with_unit},
    units::shown,
};

/// An effect at its place, such as `Coulomb friction at joint`.
#[must_use]
pub fn effect(cause: &Cause) -> String {
    effect_at(cause.label, &cause.site)
}

/// The same of a label and a place.
#[must_use]
pub fn effect_at(of: &str, site: &SiteRef) -> String {
    format!("{} {}", label(of), at(site))
}

/// A cause with the other end of a coupling, such as `coupling of states at inflow with state h_2`.
#[must_use]
pub fn cause(cause: &Cause) -> String {
    let mut name = effect(cause);
    if let Some(partner) = &cause.partner {
        let word = if cause.label == "parameter-dependence" { "on" } else { "with" };
        name = format!("{name} {word} {}", site(partner));
    }
    if let SiteRef::Signal(i, signal) = &cause.site
        && let Some(known) = cause.model.definitions.get(*i).filter(|known| known.name == *signal)
    {
        name = format!("{name} = {}", known.value);
    }
    name.trim_end().to_owned()
}

/// A cause with its strength in parentheses.
#[must_use]
pub fn with_strength(of: &Cause) -> String {
    match strength(of).as_str() {
        "" => cause(of),
        strength => format!("{} ({strength})", cause(of)),
    }
}

/// Both causes of a pair.
#[must_use]
pub fn pair(pair: &Pair) -> String {
    pair.causes.each_ref().map(cause).join(" with ")
}

/// A mechanism at a place, such as `friction at joint`.
#[must_use]
pub fn group(group: &Group) -> String {
    format!("{} {}", family(group.family), at(&group.site)).trim_end().to_owned()
}

/// A side of the plant.
#[must_use]
pub fn side(side: Side) -> &'static str {
    match side {
        Side::Input => "input",
        Side::Dynamics => "dynamics",
        Side::Output => "output",
    }
}

/// The strengths of a cause, such as `0.31 ± 0.02 N m`; a curve of many strengths by its largest value.
#[must_use]
pub fn strength(cause: &Cause) -> String {
    let strengths: Vec<&Estimate> = cause.parameters.iter().filter(|p| p.is_strength).collect();
    if cause.label.ends_with("-map") || cause.label == "parameter-wander" {
        let by_size = |a: &&&Estimate, b: &&&Estimate| a.value.abs().total_cmp(&b.value.abs());
        let largest = strengths.iter().max_by(by_size);
        return largest.map_or_else(String::new, |p| format!("up to {}", estimate(cause.label, p)));
    }
    let prefix = format!("{}_", cause.site.prefix());
    let named = |p: &&Estimate| {
        let name = p.name.strip_prefix(&prefix).unwrap_or(&p.name).replace('_', " ");
        format!("{name} {}", estimate_of(cause, p))
    };
    match &strengths[..] {
        [only] => estimate_of(cause, only),
        several => several.iter().map(named).collect::<Vec<_>>().join(", "),
    }
}

/// Value, standard error and unit of a parameter of a cause, as a person would state them: where its model says at which value
/// of the signal something sets in, that value.
#[must_use]
pub fn estimate_of(cause: &Cause, of: &Estimate) -> String {
    let [from, at] = ["from", "at"].map(|suffix| place(cause, of, suffix));
    let (.., unit) = shown(cause.label, of);
    let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
    match (from, at) {
        (Some(from), Some(at)) => format!("{from} to {at}{unit}"),
        (None, Some(at)) => format!("at {at}{unit}"),
        _ => estimate(cause.label, of),
    }
}

/// The value of a definition that stands beside a parameter, with its standard error.
fn place(cause: &Cause, of: &Estimate, suffix: &str) -> Option<String> {
    let name = format!("{}_{suffix}", of.name);
    let definition = cause.model.definitions.iter().find(|known| known.name == name)?;
    let fitted = |name: &str| cause.parameters.iter().find(|p| p.name == name);
    let value = |expr: &Expr| {
        let settled = expr.substitute(&|name| fitted(name).map(|p| Expr::Number(p.value)));
        match settled.simplify() {
            Expr::Number(value) if value.is_finite() => Some(value),
            _ => None,
        }
    };
    let slopes = cause
        .parameters
        .iter()
        .map(|p| value(&definition.value.differentiate(&p.name)).unwrap_or(0.0) * p.standard_error);
    let error = slopes.map(|change| change * change).sum::<f64>().sqrt();
    Some(with_error(value(&definition.value)?, error))
}

/// Value, standard error and unit of a parameter of an effect with a label, as a person would state them.
#[must_use]
pub fn estimate(label: &str, estimate: &Estimate) -> String {
    let (value, error, unit) = shown(label, estimate);
    // A limit that is not there.
    if value.is_infinite() {
        return "none".to_owned();
    }
    with_unit(value, error, &unit)
}
