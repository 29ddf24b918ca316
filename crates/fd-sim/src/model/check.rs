//! Checks of a draft: names, places, numbers, circles.

mod names;
mod numbers;

use std::collections::HashMap;

use fd_model::nearest;

use self::names::Meaning;
use self::numbers::Checked;
use super::{
    draft::{Draft, Law},
    error::{Mistake, ModelError},
};
use crate::equation::{Expr, MAX_DEPTH, RESERVED, in_order_of_use, locate};

/// Checks everything that [`Model`](super::Model) promises.
pub(super) fn check(draft: &Draft) -> Checked {
    numbers::check(draft)?;
    let names = names::collect(draft)?;
    let wrong = |(key, place, expr): (String, Setting, &Expr)| {
        Checker { draft, names: &names, key: &key, place }.check(expr).err()
    };
    ModelError::all(expressions(draft).into_iter().filter_map(wrong).collect())?;
    check_references(draft, &names)?;
    check_circles(draft)
}

/// What an expression may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Setting {
    Plant,
    Limit,
    Controller,
}

impl Setting {
    fn allows(self, meaning: Meaning) -> bool {
        match self {
            Self::Plant => matches!(
                meaning,
                Meaning::Parameter
                    | Meaning::Input
                    | Meaning::DrivenInput
                    | Meaning::State
                    | Meaning::Definition
                    | Meaning::Delay
                    | Meaning::Sign
            ),
            Self::Limit => meaning == Meaning::Parameter,
            Self::Controller => matches!(
                meaning,
                Meaning::Parameter
                    | Meaning::Input
                    | Meaning::Output
                    | Meaning::Reference
                    | Meaning::ControllerState
                    | Meaning::ControllerDefinition
            ),
        }
    }

    fn builtin(self) -> &'static [&'static str] {
        match self {
            Self::Plant => &["pi", "t", "dt", "first"],
            Self::Limit => &["pi"],
            Self::Controller => &["pi", "t"],
        }
    }

    fn allowed(self) -> &'static str {
        match self {
            Self::Plant => {
                "parameters, inputs, states, definitions, delays, signs, `pi`, `t`, `dt` and `first`"
            }
            Self::Limit => "parameters and `pi`",
            Self::Controller => {
                "parameters, references, outputs, inputs that it does not drive, its own states and \
                 definitions, `pi` and `t`"
            }
        }
    }
}

/// Every expression with its key and setting.
fn expressions(draft: &Draft) -> Vec<(String, Setting, &Expr)> {
    let mut all = Vec::new();
    for input in &draft.inputs {
        for limit in input.saturation.iter().flatten() {
            all.push((format!("inputs.{}.saturation", input.name), Setting::Limit, limit));
        }
    }
    for state in &draft.states {
        all.push((law_key("states", &state.name, &state.law), Setting::Plant, state.law.expr()));
    }
    for output in &draft.outputs {
        all.push((format!("outputs.{}.value", output.name), Setting::Plant, &output.value));
    }
    for definition in &draft.definitions {
        all.push((format!("definitions.{}", definition.name), Setting::Plant, &definition.value));
    }
    for delay in &draft.delays {
        all.push((format!("delays.{}.value", delay.name), Setting::Plant, &delay.value));
        all.push((format!("delays.{}.time", delay.name), Setting::Limit, &delay.time));
    }
    for sign in &draft.signs {
        all.push((format!("signs.{}", sign.name), Setting::Plant, &sign.velocity));
    }
    for site in &draft.sites {
        for (state, factor) in &site.enters {
            all.push((format!("sites.{}.enters.{state}", site.name), Setting::Plant, factor));
        }
        for (what, expr) in [("position", &site.position), ("velocity", &site.velocity)] {
            all.extend(
                expr.iter().map(|e| (format!("sites.{}.{what}", site.name), Setting::Plant, e)),
            );
        }
    }
    if let Some(controller) = &draft.controller {
        for state in &controller.states {
            let key = law_key("controller.states", &state.name, &state.law);
            all.push((key, Setting::Controller, state.law.expr()));
        }
        for definition in &controller.definitions {
            let key = format!("controller.definitions.{}", definition.name);
            all.push((key, Setting::Controller, &definition.value));
        }
        for signal in &controller.signals {
            let key = format!("controller.signals.{}", signal.input);
            all.push((key, Setting::Controller, &signal.value));
        }
    }
    all
}

fn law_key(room: &str, name: &str, law: &Law) -> String {
    let kind = if matches!(law, Law::Derivative(_)) { "derivative" } else { "update" };
    format!("{room}.{name}.{kind}")
}

struct Checker<'a> {
    draft: &'a Draft,
    names: &'a HashMap<&'a str, (Meaning, String)>,
    key: &'a str,
    place: Setting,
}

impl Checker<'_> {
    fn check(&self, expr: &Expr) -> Checked {
        if MAX_DEPTH < expr.depth() {
            return Err(ModelError::new(self.key, Mistake::TooDeep { limit: MAX_DEPTH }));
        }
        let mut result = Ok(());
        expr.visit_names(&mut |name| {
            if result.is_ok() {
                result = self.check_name(name, expr);
            }
        });
        expr.visit_tables(&mut |table| {
            if result.is_ok() && !self.draft.tables.iter().any(|known| known.name == table) {
                let tables = self.draft.tables.iter().map(|known| known.name.as_str());
                let nearest = nearest(table, tables.chain(RESERVED));
                let mistake = Mistake::UnknownFunction { name: table.to_owned(), nearest };
                result = Err(self.error(table, expr, mistake));
            }
        });
        result
    }

    fn check_name(&self, name: &str, expr: &Expr) -> Checked {
        if self.place.builtin().contains(&name) {
            return Ok(());
        }
        let allowed = self.place.allowed();
        let mistake = match self.names.get(name) {
            Some((meaning, _)) if self.place.allows(*meaning) => return Ok(()),
            Some((meaning, _)) => {
                Mistake::NotHere { name: name.to_owned(), what: meaning.description(), allowed }
            }
            None if RESERVED.contains(&name) => {
                Mistake::NotHere { name: name.to_owned(), what: "a name of the language", allowed }
            }
            None => {
                let usable = self.names.iter().filter(|(_, (m, _))| self.place.allows(*m));
                Mistake::UnknownName {
                    name: name.to_owned(),
                    nearest: nearest(name, usable.map(|(name, _)| *name)),
                }
            }
        };
        Err(self.error(name, expr, mistake))
    }

    fn error(&self, name: &str, expr: &Expr, mistake: Mistake) -> ModelError {
        let text = expr.to_string();
        let error = ModelError::new(self.key, mistake);
        match locate(&text, name) {
            Some(span) => error.in_expression(text, span),
            None => error,
        }
    }
}

/// Names that stand as keys: driven inputs and states that forces enter.
fn check_references(draft: &Draft, names: &HashMap<&str, (Meaning, String)>) -> Checked {
    let of = |meaning: fn(Meaning) -> bool| {
        names.iter().filter(move |(_, (m, _))| meaning(*m)).map(|(name, _)| *name)
    };
    let unknown = |key: String, name: &str, nearest| {
        Err(ModelError::new(key, Mistake::UnknownName { name: name.to_owned(), nearest }))
    };
    for site in &draft.sites {
        for (state, _) in &site.enters {
            if !draft.states.iter().any(|known| known.name == *state) {
                let nearest = nearest(state, of(|m| m == Meaning::State));
                return unknown(format!("sites.{}.enters", site.name), state, nearest);
            }
        }
    }
    for signal in draft.controller.iter().flat_map(|controller| &controller.signals) {
        if !draft.inputs.iter().any(|input| input.name == signal.input) {
            let nearest =
                nearest(&signal.input, of(|m| matches!(m, Meaning::Input | Meaning::DrivenInput)));
            return unknown(format!("controller.signals.{}", signal.input), &signal.input, nearest);
        }
    }
    Ok(())
}

/// Definitions, outputs and control signals must not need themselves. A sampled controller with a
/// direct path through the plant is an algebraic loop as well: at the instant of sampling, the
/// signal and the measurement would need each other.
fn check_circles(draft: &Draft) -> Checked {
    let mut named: Vec<(&str, &Expr)> = Vec::new();
    named.extend(draft.definitions.iter().map(|d| (d.name.as_str(), &d.value)));
    named.extend(draft.delays.iter().map(|d| (d.name.as_str(), &d.value)));
    named.extend(draft.outputs.iter().map(|o| (o.name.as_str(), &o.value)));
    if let Some(controller) = &draft.controller {
        named.extend(controller.definitions.iter().map(|d| (d.name.as_str(), &d.value)));
        named.extend(controller.signals.iter().map(|s| (s.input.as_str(), &s.value)));
    }
    let roots: Vec<Expr> = named.iter().map(|(name, _)| Expr::name(*name)).collect();
    in_order_of_use(&named, &roots)
        .map(drop)
        .map_err(|cycle| ModelError::new("definitions", Mistake::Cycle(cycle.0)))
}
