//! A line of a spec for each kind that there is, for tests that must see them all.
//!
//! Only with the feature `testing`. The lines stand beside the enums that read them. [`kinds`] asks the
//! enum itself what it knows, so that a test can say which kind has no line yet.

use serde::{Deserialize, de::DeserializeOwned};
use toml::de::Error;

use super::{DetectorSpec, GeneratorSpec, LearningSpec, StructureSpec, bias, detector, generator};

/// Lines as they stand in a spec, each with what it says.
pub type Lines<T> = Vec<(&'static str, T)>;

#[derive(Deserialize)]
struct Table<T> {
    table: T,
}

/// What a line without its braces says, such as `kind = "observer", rate = 2.0`.
///
/// # Errors
///
/// Returns an error when the kind or a setting is unknown.
pub fn read<T: DeserializeOwned>(line: &str) -> Result<T, Error> {
    toml::from_str::<Table<T>>(&format!("table = {{ {line} }}")).map(|read| read.table)
}

/// The kinds that a table of a spec may have, from what it says of one that it does not know.
#[must_use]
pub fn kinds<T: DeserializeOwned>() -> Vec<String> {
    let refusal = read::<T>("kind = \"?\"").err().map(|error| error.to_string());
    let known = refusal.as_deref().and_then(|text| text.split_once("expected")).unwrap_or_default();
    known.1.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// Every residual generator, for a model of one input, two states and two outputs.
///
/// # Errors
///
/// Returns the first line that is not one.
pub fn every_generator() -> Result<Lines<GeneratorSpec>, Error> {
    all(&generator::EVERY)
}

/// Every detector.
///
/// # Errors
///
/// As [`every_generator`].
pub fn every_detector() -> Result<Lines<DetectorSpec>, Error> {
    all(&detector::EVERY)
}

/// Every structure of a bias model, the default first.
///
/// # Errors
///
/// As [`every_generator`].
pub fn every_structure() -> Result<Lines<StructureSpec>, Error> {
    all(&bias::EVERY_STRUCTURE)
}

/// Every way to learn the parameters of a bias model, the default first.
///
/// # Errors
///
/// As [`every_generator`].
pub fn every_learning() -> Result<Lines<LearningSpec>, Error> {
    all(&bias::EVERY_LEARNING)
}

fn all<T: DeserializeOwned>(lines: &[&'static str]) -> Result<Lines<T>, Error> {
    lines.iter().map(|line| Ok((*line, read(line)?))).collect()
}
