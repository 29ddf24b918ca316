//! The past values of a delayed expression.

use fd_core::Scalar;

/// Longest delay, in integration steps; a longer one is cut.
const LONGEST: f64 = 1_048_576.0;

/// A ring of the values that an expression had at the starts of integration steps.
#[derive(Clone, Debug)]
pub(super) struct DelayLine<T> {
    past: Vec<T>,
    /// Place of the value of this step.
    now: usize,
    /// Whole steps of the delay.
    whole: usize,
    /// What is left, as a fraction of a step.
    fraction: T,
    /// Number of values so far.
    age: u64,
}

impl<T: Scalar> DelayLine<T> {
    pub(super) fn new() -> Self {
        Self { past: Vec::new(), now: 0, whole: 0, fraction: T::zero(), age: 0 }
    }

    /// Forgets the past and sets the delay, in integration steps. Allocates only for a delay that
    /// is longer than any before.
    pub(super) fn start(&mut self, steps: T) {
        let whole = steps.to_report().clamp(0.0, LONGEST).floor();
        self.fraction = steps - T::from_design(whole);
        if whole >= LONGEST {
            self.fraction = T::zero();
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped; NaN is 0"
        )]
        let whole = whole as usize;
        self.whole = whole;
        self.past.resize(self.past.len().max(whole + 2), T::zero());
        self.age = 0;
    }

    /// Moves on to the next step, at the start of which the expression has this value.
    pub(super) fn push(&mut self, value: T) {
        self.now = (self.now + 1) % self.past.len();
        self.age += 1;
        self.correct(value);
    }

    /// Replaces the value of this step.
    pub(super) fn correct(&mut self, value: T) {
        if self.age == 1 {
            // Before the run, nothing moved.
            self.past.fill(value);
        } else {
            self.past[self.now] = value;
        }
    }

    /// The delayed value, mean over this step.
    pub(super) fn value(&self) -> T {
        let ago = |steps: usize| self.past[(self.now + self.past.len() - steps) % self.past.len()];
        let (newer, older) = (ago(self.whole), ago(self.whole + 1));
        newer + (older - newer) * self.fraction
    }
}
