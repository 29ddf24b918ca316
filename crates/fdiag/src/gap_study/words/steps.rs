//! Outputs that are logged in steps, which count as noise.

use super::sized_outputs::sized_outputs;
use crate::gap_study::report::Report;

/// Outputs that are logged in steps, each with its step, such as "`speed` (0.25 m/s)"; `None` where there is none.
pub(in crate::gap_study) fn steps(report: &Report) -> Option<String> {
    sized_outputs(report, |c| *report.diagnosis.steps.get(c)?)
}
