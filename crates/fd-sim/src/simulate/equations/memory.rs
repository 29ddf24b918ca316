//! The memory of a running model, for snapshots.

use fd_core::StateVisitor;

use super::engine::Engine;

/// Largest number of a sample that is gone on from: 34 years at a kilohertz.
const MOST_SAMPLES: u64 = 1 << 40;

impl Engine<f64> {
    /// Shows states, held values, delay lines and the place in time.
    pub(super) fn visit_memory(&mut self, visitor: &mut dyn StateVisitor<f64>) {
        // What has diverged is NaN.
        visitor.reals_with_holes("states of the model", &mut self.x);
        visitor.reals_with_holes("held values of the model", &mut self.held);
        if let Some(signs) = &mut self.signs {
            visitor.reals_with_holes("slopes of signs of the model", &mut signs.slopes);
        }
        for line in &mut self.lines {
            line.visit_memory(visitor);
        }
        let mut counts = [self.sample, u64::from(self.is_first)];
        visitor.counts("sample of the model, is first", &mut counts);
        (self.sample, self.is_first) = (counts[0].min(MOST_SAMPLES), counts[1] != 0);
    }
}
