//! A detector over recorded residuals: how near it came to an alarm, and when it raised one.

use fd_compensate::{decide::Debouncing, evaluate::debounced_statistics};
use fd_core::stage::Detector;
use fd_model::Record;

use crate::road::Trace;

/// Statistic over threshold, sample by sample, as the rule sees it: above `factor` means an alarm
/// when all thresholds are taken `factor` times. The record gives the inputs; it has no missing
/// samples.
pub(super) fn margins(
    detector: &mut dyn Detector,
    record: &Record,
    residual: &[f64],
    rule: Debouncing,
) -> Vec<f64> {
    let channels = detector.residual_len();
    detector.reset();
    let ratios: Vec<f64> = residual
        .chunks_exact(channels)
        .enumerate()
        .map(|(k, r)| {
            let verdict = detector.update(record.u(k), r);
            verdict.statistic / verdict.threshold
        })
        .collect();
    debounced_statistics(&ratios, rule)
}

/// The largest margin of a run.
pub(super) fn peak(margins: &[f64]) -> f64 {
    // Finite, so that it can be written as JSON.
    margins.iter().fold(0.0, |most: f64, &margin| most.max(margin)).min(f64::MAX)
}

/// First sample above `factor`.
pub(super) fn first_above(margins: &[f64], factor: f64) -> Option<usize> {
    margins.iter().position(|&margin| margin > factor)
}

/// The residual of a trace with or without compensation.
pub(super) fn residual(trace: &Trace, compensated: bool) -> &[f64] {
    if compensated { &trace.compensated } else { &trace.residual }
}
