//! What the failures of a monitor mean on the command line.

use fd_watch::{PlanError, StateError};

use super::super::failure::Failure;

/// A state that cannot be written is a result that cannot be written; anything else is a wrong input.
pub(super) fn of_state(error: StateError) -> Failure {
    match error {
        StateError::Io { path, source, action: "write" | "sync" | "make" } => {
            Failure::output(path, source)
        }
        error => Failure::of_input(error),
    }
}

/// What cannot be planned is due to the data, unless it is the command line.
pub(super) fn of_plan(error: PlanError) -> Failure {
    match error {
        PlanError::NoSampleTime => Failure::of_input(format!("{error} (--sample-time)")),
        PlanError::SampleTime { .. } | PlanError::Range { .. } | PlanError::Alarms(_) => {
            Failure::of_input(error)
        }
        error => Failure::analysis(error),
    }
}
