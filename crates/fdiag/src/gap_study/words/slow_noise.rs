//! Outputs whose slow errors were taken for noise although no noise is stated.

use fd_model::figure;
use fd_sim::model::Output;

use super::labels::list;
use crate::gap_study::report::Report;

/// Outputs with slow noise that nobody states, each with its size, such as "`speed` (0.31 m/s)"; `None` where there
/// is none.
pub(in crate::gap_study) fn slow_noise(report: &Report) -> Option<String> {
    let diagnosis = &report.diagnosis;
    let of = |(c, output): (usize, &Output)| {
        let size = diagnosis.sigma.get(c)? * diagnosis.best.gap.get(c)?;
        let is_slow = diagnosis.slow_noise.get(c).copied().unwrap_or_default();
        is_slow.then(|| format!("`{}` ({} {})", output.name, figure(size), output.unit))
    };
    let slow: Vec<String> = report.inputs.outputs.iter().enumerate().filter_map(of).collect();
    (!slow.is_empty()).then(|| list(&slow, "and"))
}
