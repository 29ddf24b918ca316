//! The statistics that a threshold is found from.

use fd_core::stage::Detector;

use crate::{decide::Debouncing, evaluate::debounced_statistics, rows::DrivenRows};

/// The debounced statistics of a reset detector over the samples `drawn`.
pub(super) fn statistics<D: Detector<f64> + ?Sized>(
    detector: &mut D,
    healthy: DrivenRows<'_>,
    drawn: impl Iterator<Item = usize>,
    debouncing: Debouncing,
) -> Vec<f64> {
    detector.reset();
    let raw: Vec<f64> =
        drawn.map(|k| detector.update(healthy.u(k), healthy.r(k)).statistic).collect();
    debounced_statistics(&raw, debouncing)
}
