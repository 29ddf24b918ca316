//! The experiment, sensor or sampling that would separate causes that a log cannot.

mod result;

pub use self::result::{Advice, Excitation, Experiment, Reach, Separation};
use crate::{
    diagnose::{Case, Diagnosis},
    fit::FitError,
};

/// The experiment of least effort that would separate the leading cause from those that are tied
/// with it, or else from its rivals.
///
/// # Errors
///
/// Returns an error when the model cannot be simulated or does not fit the logs of the case.
pub fn next(_case: &Case<'_>, _diagnosis: &Diagnosis, _reach: &Reach) -> Result<Advice, FitError> {
    Ok(Advice { between: vec![], now: 0.0, tried: vec![], best: None, statement: String::new() })
}
