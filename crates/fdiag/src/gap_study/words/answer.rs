//! Causes, with their places and strengths.

use fd_effect::{Side, SiteRef};
use fd_gap::diagnose::{Cause, Estimate, Group, Pair};

use super::{
    labels::{at, family, label, site},
    numbers::with_error,
    units::shown,
};

/// An effect at its place, such as `Coulomb friction at joint`.
#[must_use]
pub fn effect(cause: &Cause) -> String {
    format!("{} {}", label(cause.label), at(&cause.site))
}

/// A cause with the other end of a coupling, such as `coupling of states at inflow with state h_2`.
#[must_use]
pub fn cause(cause: &Cause) -> String {
    let mut name = effect(cause);
    if let Some(partner) = &cause.partner {
        name = format!("{name} with {}", site(partner));
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
    let prefix = format!("{}_", cause.site.name().unwrap_or("plant"));
    let named = |p: &&Estimate| {
        let name = p.name.strip_prefix(&prefix).unwrap_or(&p.name).replace('_', " ");
        format!("{name} {}", estimate(cause.label, p))
    };
    match &strengths[..] {
        [only] => estimate(cause.label, only),
        several => several.iter().map(named).collect::<Vec<_>>().join(", "),
    }
}

/// Value, standard error and unit of a parameter of an effect with a label, as a person would state them.
#[must_use]
pub fn estimate(label: &str, estimate: &Estimate) -> String {
    let (value, error, unit) = shown(label, estimate);
    // A limit that is not there.
    if value.is_infinite() {
        return "none".to_owned();
    }
    let value = with_error(value, error);
    match unit.as_str() {
        "1" | "" => value,
        unit => format!("{value} {unit}"),
    }
}
