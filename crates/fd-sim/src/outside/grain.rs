//! Whether outputs are in single precision, as those of simulators on graphics cards are.

use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// What was seen of the outputs of a simulator.
#[derive(Debug, Default)]
pub(super) struct Grain {
    /// An output that is not zero.
    is_seen: AtomicBool,
    /// One that single precision does not have.
    is_double: AtomicBool,
}

impl Grain {
    /// Looks at outputs.
    #[expect(clippy::cast_possible_truncation, reason = "that is the question")]
    pub(super) fn look(&self, y: &[f64]) {
        if self.is_double.load(Relaxed) {
            return;
        }
        for value in y.iter().filter(|value| value.is_finite() && **value != 0.0) {
            self.is_seen.store(true, Relaxed);
            if f64::from(*value as f32).to_bits() != value.to_bits() {
                self.is_double.store(true, Relaxed);
                return;
            }
        }
    }

    /// Relative error of the outputs by rounding.
    pub(super) fn precision(&self) -> f64 {
        let is_single = self.is_seen.load(Relaxed) && !self.is_double.load(Relaxed);
        if is_single { f64::from(f32::EPSILON) } else { f64::EPSILON }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_precision_is_seen_and_zeros_say_nothing() {
        let grain = Grain::default();
        grain.look(&[0.0, f64::NAN]);
        assert!(grain.precision() < 1e-15);
        grain.look(&[0.5, f64::from(0.1_f32)]);
        assert!(1e-7 < grain.precision());
        grain.look(&[0.1]);
        assert!(grain.precision() < 1e-15);
    }
}
