//! How a study that is refused is told.

use fdiag::{core::Resource, gap::fit::FitError, gap_study::GapError};

use super::failure::Failure;

/// What cannot be simulated or fitted is no mistake of a file.
pub(super) fn refusal(error: &GapError) -> Failure {
    let reason = error.to_string();
    let is_analysis = match error {
        GapError::Outside { error, .. } => {
            return match refusal(error) {
                Failure::Analysis(_) => Failure::analysis(reason),
                _ => Failure::of_input(reason),
            };
        }
        GapError::Limit(limit) => limit.resource != Resource::Bytes,
        GapError::Budget { .. } | GapError::Simulate(_) | GapError::Fit(_) => true,
        GapError::Unfit { source, .. } => matches!(**source, FitError::TooShort { .. }),
        _ => false,
    };
    if is_analysis { Failure::Analysis(reason) } else { Failure::of_input(reason) }
}
