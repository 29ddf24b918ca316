//! An effect as text against a model.

use std::hash::{DefaultHasher, Hash, Hasher};

use fd_model::nearest;
use fd_sim::{
    equation::{Expr, Table, Values},
    model::Model,
};

use super::{On, TextEffect, TextError};

/// Values of all names at which a law must be absent with its strengths.
const TRIALS: u64 = 16;
/// Rounding of a few operations, relative: strengths of exactly 0 leave no more.
const ROUNDING: f64 = 1e-12;

impl TextEffect {
    /// Label, law and places as one text.
    #[must_use]
    pub fn shown(&self) -> String {
        let at =
            if self.at.is_empty() { String::new() } else { format!(" at {}", self.at.join(", ")) };
        format!("{}{at}: {}", self.label, self.law)
    }

    /// Checks that its places and names are those of a model, and that it is absent with its strengths.
    ///
    /// # Errors
    ///
    /// Returns what is wrong first, with the name that may be meant.
    pub fn check(&self, model: &Model) -> Result<(), TextError> {
        let places = self.places(model);
        for at in &self.at {
            self.is_among("at", at, &places)?;
        }
        let known = self.names(model);
        let laws = self.states.iter().map(|(name, _, rate)| (format!("states.{name}"), rate));
        for (key, law) in laws.chain([("law".to_owned(), &self.law)]) {
            let (mut names, mut tables) = (Vec::new(), Vec::new());
            law.visit_names(&mut |name| names.push(name));
            law.visit_tables(&mut |name| tables.push(name));
            for name in names {
                self.is_among(&key, name, &known)?;
            }
            let all: Vec<&str> = model.tables.iter().map(|table| table.name.as_str()).collect();
            for name in tables {
                self.is_among(&key, name, &all)?;
            }
        }
        self.is_absent_at_zero(model)
    }

    /// Names of the places that the model has for it.
    fn places<'a>(&self, model: &'a Model) -> Vec<&'a str> {
        match self.on {
            On::Input => model.inputs.iter().map(|input| input.name.as_str()).collect(),
            On::Force => model.sites.iter().map(|site| site.name.as_str()).collect(),
            On::Output => model.outputs.iter().map(|output| output.name.as_str()).collect(),
            On::Parameter => model.parameters.iter().map(|p| p.name.as_str()).collect(),
        }
    }

    /// Everything that may be named in a law.
    fn names<'a>(&'a self, model: &'a Model) -> Vec<&'a str> {
        let own = self.parameters.iter().map(|(name, _)| name.as_str());
        let states = self.states.iter().map(|(name, ..)| name.as_str());
        let of_model = (model.parameters.iter().map(|p| p.name.as_str()))
            .chain(model.inputs.iter().map(|input| input.name.as_str()))
            .chain(model.states.iter().map(|state| state.name.as_str()))
            .chain(model.definitions.iter().map(|definition| definition.name.as_str()))
            .chain(model.delays.iter().map(|delay| delay.name.as_str()))
            .chain(model.signs.iter().map(|sign| sign.name.as_str()));
        let always = ["t", "dt", "first", "pi"];
        let locals = self.on.locals().iter().copied();
        own.chain(states).chain(locals).chain(always).chain(of_model).collect()
    }

    fn is_among(&self, key: &str, name: &str, known: &[&str]) -> Result<(), TextError> {
        if known.contains(&name) {
            return Ok(());
        }
        let near = nearest(name, known.iter().copied());
        let expected = match (near.first(), known) {
            (Some(near), _) => format!("a name of the model or the effect; did you mean `{near}`?"),
            (None, []) => "none: the model has no such place".to_owned(),
            (None, _) => format!("one of `{}`", known.join("`, `")),
        };
        Err(self.wrong(key, expected, format!("`{name}`")))
    }

    fn is_absent_at_zero(&self, model: &Model) -> Result<(), TextError> {
        let absent = Expr::parse(self.on.absent());
        let absent = absent.unwrap_or(Expr::Number(0.0));
        for trial in 0..TRIALS {
            let values = Trial { effect: self, model, number: trial };
            let [found, expected] = [&self.law, &absent].map(|law| law.evaluate(&values));
            let (Ok(found), Ok(expected)) = (found, expected) else { continue };
            let rest: f64 = found - expected;
            // A law that has no value somewhere, such as a root, says nothing there.
            if found.is_finite() && ROUNDING * expected.abs() < rest.abs() {
                let expected = format!("`{}` where all strengths are 0", self.on.absent());
                let found = format!("{found} instead of {}", found - rest);
                return Err(self.wrong("law", expected, found));
            }
        }
        Ok(())
    }

    fn wrong(&self, key: &str, expected: String, found: String) -> TextError {
        TextError::Value { label: self.label.to_owned(), key: key.to_owned(), expected, found }
    }
}

/// Some values of all names, with all strengths at 0.
struct Trial<'a> {
    effect: &'a TextEffect,
    model: &'a Model,
    number: u64,
}

impl Values<f64> for Trial<'_> {
    fn value(&self, name: &str) -> Option<f64> {
        let own = self.effect.parameters.iter().find(|(known, _)| known == name);
        if let Some((_, parameter)) = own {
            return Some(parameter.shape.unwrap_or(0.0));
        }
        let mut hasher = DefaultHasher::new();
        (name, self.number).hash(&mut hasher);
        // Anything between -2 and 2.
        Some(4.0 * (hasher.finish() % 1_000_003) as f64 / 1_000_003.0 - 2.0)
    }

    fn table(&self, name: &str) -> Option<&Table> {
        self.model.tables.iter().find(|known| known.name == name).map(|known| &known.table)
    }
}
