//! Names of effects and places.

use fd_effect::SiteRef;
use fd_gap::estimate::Standing;

/// Labels of the library and of the engine that are more than their dashes turned to spaces.
const LABELS: [(&str, &str); 22] = [
    ("coulomb-friction", "Coulomb friction"),
    ("drag", "quadratic drag"),
    ("linear-stiffness", "linear stiffness"),
    ("stiffening", "stiffening spring"),
    ("gravity-load", "gravity-like load"),
    ("end-stop", "end stop"),
    ("input-gain", "gain error"),
    ("sensor-scale", "scale error of the sensor"),
    ("parameter-error", "error"),
    ("parameter-dependence", "dependence"),
    ("parameter-event", "change"),
    ("parameter-wander", "wandering"),
    ("input-power", "power law"),
    ("input-map", "unknown curve"),
    ("force-map", "unknown force"),
    ("sensor-map", "unknown curve of the sensor"),
    ("state-coupling", "coupling of states"),
    ("module-efficiency", "shift"),
    ("flow-capacity", "shift"),
    ("bleed-leak", "shift"),
    ("nozzle-area", "shift"),
    ("combustion", "shift"),
];

/// A label in words, such as `Coulomb friction`.
#[must_use]
pub fn label(label: &str) -> String {
    let known = LABELS.iter().find(|(known, _)| *known == label);
    known.map_or_else(
        || label.strip_prefix("input-").unwrap_or(label).replace('-', " "),
        |(_, words)| (*words).to_owned(),
    )
}

/// A family in words.
#[must_use]
pub fn family(family: &str) -> String {
    match family {
        "map" => "unknown law".to_owned(),
        "parameter" => "error".to_owned(),
        // What engines suffer from is one parameter of their health each.
        "module" | "bleed" | "nozzle" | "combustion" => "condition".to_owned(),
        family => family.replace('-', " "),
    }
}

/// A place with the word that goes before it, such as `at input u`.
#[must_use]
pub fn at(place: &SiteRef) -> String {
    match place {
        SiteRef::Input(_, name) => format!("at input {name}"),
        SiteRef::Force(_, name) => format!("at {name}"),
        SiteRef::State(_, name) => format!("in the equation of {name}"),
        SiteRef::Output(_, name) => format!("on output {name}"),
        SiteRef::Signal(_, name) => format!("on {name}"),
        SiteRef::Parameter(_, name) => format!("of parameter {name}"),
        SiteRef::Part(_, name) => format!("of {name}"),
        SiteRef::Alike(..) => format!("at {}", site(place)),
        SiteRef::WholeModel => String::new(),
    }
}

/// A place alone, such as `input u`.
#[must_use]
pub fn site(site: &SiteRef) -> String {
    match site {
        SiteRef::Input(_, name) => format!("input {name}"),
        SiteRef::Force(_, name) | SiteRef::Part(_, name) => name.clone(),
        SiteRef::State(_, name) => format!("state {name}"),
        SiteRef::Output(_, name) => format!("output {name}"),
        SiteRef::Signal(_, name) => format!("signal {name}"),
        SiteRef::Parameter(_, name) => format!("parameter {name}"),
        SiteRef::Alike(places, names) => match places.first() {
            Some(SiteRef::Input(..)) => format!("inputs {names} alike"),
            Some(SiteRef::Output(..)) => format!("outputs {names} alike"),
            _ => format!("{names} alike"),
        },
        SiteRef::WholeModel => "the whole model".to_owned(),
    }
}

/// What logs say of an uncertain parameter.
#[must_use]
pub fn standing(standing: Standing) -> &'static str {
    match standing {
        Standing::Found => "found",
        Standing::InCombination => "only in combination",
        Standing::Unmoved => "not moved by these logs",
        Standing::AtEdge => "AT THE EDGE of its tolerance or bounds",
    }
}

/// `a`, `a or b`, `a, b or c`.
#[must_use]
pub fn list(words: &[String], last: &str) -> String {
    match words {
        [] => String::new(),
        [only] => only.clone(),
        [first @ .., end] => format!("{} {last} {end}", first.join(", ")),
    }
}

/// The text with a capital letter at its beginning.
#[must_use]
pub fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |c| c.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_read_like_words() {
        assert_eq!(label("coulomb-friction"), "Coulomb friction");
        assert_eq!(label("input-dead-zone"), "dead zone");
        assert_eq!(label("sensor-lag"), "sensor lag");
        assert_eq!(list(&["a", "b", "c"].map(str::to_owned), "or"), "a, b or c");
    }
}
