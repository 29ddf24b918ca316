//! Some outputs, each with a size.

use fd_model::figure;
use fd_sim::model::Output;

use super::labels::list;
use crate::gap_study::report::Report;

/// The outputs that have a size, by place, each with it, such as "`speed` (0.31 m/s) and `angle` (0.2 rad)"; `None` where
/// none has.
pub(super) fn sized_outputs(
    report: &Report,
    size: impl Fn(usize) -> Option<f64>,
) -> Option<String> {
    let of = |(c, output): (usize, &Output)| {
        Some(format!("`{}` ({} {})", output.name, figure(size(c)?), output.unit))
    };
    let named: Vec<String> = report.inputs.outputs.iter().enumerate().filter_map(of).collect();
    (!named.is_empty()).then(|| list(&named, "and"))
}
