//! Outputs whose slow errors were taken for noise although no noise is stated.

use super::sized_outputs::sized_outputs;
use crate::gap_study::report::Report;

/// Outputs with slow noise that nobody states, each with its size, such as "`speed` (0.31 m/s)"; `None` where there
/// is none.
pub(in crate::gap_study) fn slow_noise(report: &Report) -> Option<String> {
    let diagnosis = &report.diagnosis;
    sized_outputs(report, |c| {
        let size = diagnosis.sigma.get(c)? * diagnosis.best.gap.get(c)?;
        diagnosis.slow_noise.get(c).copied().unwrap_or_default().then_some(size)
    })
}
