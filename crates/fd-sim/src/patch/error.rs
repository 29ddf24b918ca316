//! Why a model cannot be patched.

use thiserror::Error;

use crate::model::ModelError;

/// A model cannot be patched.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PatchError {
    /// The place of the effect does not exist.
    #[error("the model has no {what} `{name}`, only {}", list(.known))]
    Unknown {
        /// Kind of place.
        what: &'static str,
        /// Name that was asked for.
        name: String,
        /// Names there are.
        known: Vec<String>,
    },
    /// The patched model is not correct.
    #[error("patched model: {0}")]
    Model(#[from] ModelError),
}

fn list(names: &[String]) -> String {
    match names {
        [] => "none at all".to_owned(),
        names => format!("`{}`", names.join("`, `")),
    }
}
