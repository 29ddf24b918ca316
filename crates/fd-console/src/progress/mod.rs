//! Progress on standard error, only when somebody is looking.

mod bar;
mod stages;

use std::time::Duration;

use indicatif::ProgressDrawTarget;

pub use self::{bar::Bar, stages::Stages};
use crate::say::is_watched;

/// Time between two drawings.
const TICK: Duration = Duration::from_millis(200);

/// Standard error where somebody looks at it.
fn target() -> ProgressDrawTarget {
    if is_watched() { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() }
}
