//! What the best start of a candidate changes.

/// A change of residuals, by amplitudes within a range.
#[derive(Clone, Debug, Default)]
pub(super) struct Change {
    pub range: [f64; 2],
    pub residuals: Vec<f32>,
}

impl Change {
    #[expect(clippy::cast_possible_truncation, reason = "seven digits rank a thousand candidates")]
    pub(super) fn new(range: [f64; 2], residuals: &[f64]) -> Self {
        Self { range, residuals: residuals.iter().map(|r| *r as f32).collect() }
    }
}
