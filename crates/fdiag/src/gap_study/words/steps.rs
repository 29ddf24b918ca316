//! Outputs that are logged in steps, which count as noise.

use fd_model::figure;
use fd_sim::model::Output;

use super::labels::list;
use crate::gap_study::report::Report;

/// Outputs that are logged in steps, each with its step, such as "`speed` (0.25 m/s)"; `None` where there is none.
pub(in crate::gap_study) fn steps(report: &Report) -> Option<String> {
    let of = |(output, step): (&Output, &Option<f64>)| {
        step.map(|step| format!("`{}` ({} {})", output.name, figure(step), output.unit))
    };
    let outputs = report.inputs.outputs.iter().zip(&report.diagnosis.steps);
    let stepped: Vec<String> = outputs.filter_map(of).collect();
    (!stepped.is_empty()).then(|| list(&stepped, "and"))
}
