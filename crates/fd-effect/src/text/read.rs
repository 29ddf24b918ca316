//! Effects as they are written.

use std::{collections::BTreeMap, path::Path};

use fd_model::file::{SettingsError, read_settings};
use fd_sim::equation::{Expr, is_name};
use serde::Deserialize;

use super::{
    On, TextEffect,
    error::TextError,
    parameter::{TextParameter, TextState},
};
use crate::{label::interned, library};

/// Longest label, in characters.
const LONGEST: usize = 64;
/// Most parameters of an effect: fits of more wander.
const MOST: usize = 8;

/// Effects by label, as a file of TOML or a program states them.
///
/// ```
/// use fd_effect::text::TextEffects;
///
/// let wrong: TextEffects = serde_json::from_str(r#"{"leak": {"side": "inlet", "law": "u"}}"#)?;
/// let error = wrong.effects().unwrap_err();
/// assert_eq!(
///     error.to_string(),
///     "effect `leak`: side: expected `input`, `force`, `output` or `parameter`, found `inlet`"
/// );
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(transparent)]
pub struct TextEffects(BTreeMap<String, Written>);

/// One effect as it is written.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    side: String,
    law: String,
    family: Option<String>,
    #[serde(default)]
    at: Vec<String>,
    #[serde(default)]
    parameters: BTreeMap<String, TextParameter>,
    #[serde(default)]
    states: BTreeMap<String, TextState>,
}

impl TextEffects {
    /// Reads effects from a TOML file.
    ///
    /// # Errors
    ///
    /// As [`read_settings`].
    pub fn read(file: &Path) -> Result<Self, SettingsError> {
        read_settings(file)
    }

    /// The effects, checked as far as that is possible without a model.
    ///
    /// # Errors
    ///
    /// Returns the first entry that is wrong.
    pub fn effects(self) -> Result<Vec<TextEffect>, TextError> {
        self.0.into_iter().map(|(label, written)| written.effect(&label)).collect()
    }
}

impl Written {
    fn effect(self, label: &str) -> Result<TextEffect, TextError> {
        let wrong = |key: String, expected: &str, found: String| TextError::Value {
            label: label.to_owned(),
            key,
            expected: expected.to_owned(),
            found,
        };
        let quoted = |text: &str| format!("`{text}`");
        let word = "a word of small letters, digits and dashes, such as `daily-swing`";
        if !is_label(label) {
            return Err(wrong("label".to_owned(), word, quoted(label)));
        }
        if library().iter().any(|known| known.label() == label) {
            let expected = "a label that no effect of the library has";
            return Err(wrong("label".to_owned(), expected, quoted(label)));
        }
        if let Some(family) = self.family.as_deref().filter(|family| !is_label(family)) {
            return Err(wrong("family".to_owned(), word, quoted(family)));
        }
        let on = On::ALL.into_iter().find(|(name, _)| *name == self.side).map(|(_, on)| on);
        let Some(on) = on else {
            let expected = "`input`, `force`, `output` or `parameter`";
            return Err(wrong("side".to_owned(), expected, quoted(&self.side)));
        };
        let is_taken =
            |name: &str| on.locals().contains(&name) || matches!(name, "t" | "dt" | "first" | "pi");
        let names = self.parameters.keys().map(|name| ("parameters", name));
        for (room, name) in names.chain(self.states.keys().map(|name| ("states", name))) {
            if !is_name(name) || is_taken(name) {
                let expected =
                    "a name that can stand in an expression and means nothing else there";
                return Err(wrong(room.to_owned(), expected, quoted(name)));
            }
        }
        if let Some(name) = self.states.keys().find(|name| self.parameters.contains_key(*name)) {
            return Err(wrong("states".to_owned(), "names that no parameter has", quoted(name)));
        }
        if !self.parameters.values().any(TextParameter::is_strength) || MOST < self.parameters.len()
        {
            let expected = format!("a strength, and at most {MOST} parameters in all");
            let found = format!("{} parameters", self.parameters.len());
            return Err(wrong("parameters".to_owned(), &expected, found));
        }
        for (name, parameter) in &self.parameters {
            if let Some((key, expected, found)) = parameter.problem() {
                return Err(wrong(format!("parameters.{name}.{key}"), &expected, found));
            }
        }
        let parsed = |key: String, text: &str| {
            Expr::parse(text).map_err(|error| TextError::Syntax {
                label: label.to_owned(),
                key,
                error: Box::new(error),
            })
        };
        let states = self.states.into_iter().map(|(name, state)| {
            let rate = parsed(format!("states.{name}.derivative"), &state.derivative)?;
            Ok((name, state, rate))
        });
        let effect = TextEffect {
            label: interned(label),
            family: interned(self.family.as_deref().unwrap_or(label)),
            on,
            at: self.at,
            law: parsed("law".to_owned(), &self.law)?,
            states: states.collect::<Result<_, _>>()?,
            parameters: self.parameters.into_iter().collect(),
        };
        Ok(effect)
    }
}

fn is_label(text: &str) -> bool {
    let is_fine = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    text.starts_with(|c: char| c.is_ascii_lowercase())
        && text.len() <= LONGEST
        && text.chars().all(is_fine)
}
