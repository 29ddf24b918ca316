//! The past values of a delayed expression.

use fd_core::{Scalar, StateVisitor};

use crate::equation::Value;

/// Longest delay, in integration steps; a longer one is cut.
const LONGEST: f64 = 1_048_576.0;

/// A ring of the values that an expression had at the starts of integration steps.
#[derive(Clone, Debug)]
pub(super) struct DelayLine<V> {
    past: Vec<V>,
    /// Place of the value of this step.
    now: usize,
    /// Whole steps of the delay of each lane.
    whole: Vec<usize>,
    /// What is left, as a fraction of a step.
    fraction: V,
    /// Number of values so far.
    age: u64,
}

impl DelayLine<f64> {
    /// Shows the past values and the place in the ring.
    pub(super) fn visit_memory(&mut self, visitor: &mut dyn StateVisitor<f64>) {
        visitor.reals_with_holes("past values of a delay", &mut self.past);
        let mut counts = [self.now as u64, self.age];
        visitor.counts("place and age of a delay", &mut counts);
        // A number from a file is brought into range.
        self.now = usize::try_from(counts[0]).unwrap_or(0) % self.past.len().max(1);
        self.age = counts[1];
    }
}

impl<V: Value> DelayLine<V> {
    pub(super) fn new() -> Self {
        let (whole, fraction) = (vec![0; V::LANES], V::constant(0.0));
        Self { past: Vec::new(), now: 0, whole, fraction, age: 0 }
    }

    /// Forgets the past and sets the delay, in integration steps. Allocates only for a delay that
    /// is longer than any before.
    pub(super) fn start(&mut self, steps: V) {
        for (lane, to) in self.whole.iter_mut().enumerate() {
            let steps = steps.lane(lane);
            let whole = steps.to_report().clamp(0.0, LONGEST).floor();
            let is_cut = whole >= LONGEST;
            let left = steps - Scalar::from_design(whole);
            self.fraction.set_lane(lane, if is_cut { Scalar::from_design(0.0) } else { left });
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "clamped; NaN is 0"
            )]
            let whole = whole as usize;
            *to = whole;
            self.past.resize(self.past.len().max(whole + 2), V::constant(0.0));
        }
        self.age = 0;
    }

    /// Moves on to the next step, at the start of which the expression has this value.
    pub(super) fn push(&mut self, value: V) {
        self.now = if self.now + 1 < self.past.len() { self.now + 1 } else { 0 };
        self.age += 1;
        self.correct(value);
    }

    /// Replaces the value of this step.
    pub(super) fn correct(&mut self, value: V) {
        if self.age == 1 {
            // Before the run, nothing moved.
            self.past.fill(value);
        } else {
            self.past[self.now] = value;
        }
    }

    /// The delayed value, mean over this step.
    pub(super) fn value(&self) -> V {
        // At most as many steps ago as the ring is long.
        let ago = |steps: usize| {
            let wrapped = if steps <= self.now { 0 } else { self.past.len() };
            &self.past[self.now + wrapped - steps]
        };
        let (mut newer, mut older) = (V::constant(0.0), V::constant(0.0));
        for (lane, whole) in self.whole.iter().enumerate() {
            newer.set_lane(lane, ago(*whole).lane(lane));
            older.set_lane(lane, ago(*whole + 1).lane(lane));
        }
        newer.zip3(older, self.fraction, |newer, older, f| newer + (older - newer) * f)
    }
}
