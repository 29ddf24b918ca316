//! The guard that watches whether the input stays in the range that was trained.

use fd_core::{EventKind, Events, Scalar, StateVisitor};

use super::design::{OperatingPoint, RangePolicy};

/// Learns the range of each input in training and compares a low-passed input with it afterwards.
#[derive(Clone, Debug)]
pub(super) struct OperatingPointGuard<T> {
    policy: RangePolicy,
    gain: T,
    margin: T,
    margin_absolute: T,
    band: T,
    low: Vec<T>,
    high: Vec<T>,
    slow: Vec<T>,
    anchor: Vec<T>,
    has_sample: bool,
    outside: bool,
    settled: u64,
}

impl<T: Scalar> OperatingPointGuard<T> {
    pub(super) fn new(plan: &OperatingPoint, nu: usize) -> Self {
        let band = match plan.policy {
            RangePolicy::RetrainAfter { band, .. } => band,
            _ => 0.0,
        };
        let zeros = vec![T::zero(); nu];
        Self {
            policy: plan.policy,
            gain: T::from_design((1.0 + plan.time_constant).recip()),
            margin: T::from_design(plan.margin),
            margin_absolute: T::from_design(plan.margin_absolute),
            band: T::from_design(band),
            low: zeros.clone(),
            high: zeros.clone(),
            slow: zeros.clone(),
            anchor: zeros,
            has_sample: false,
            outside: false,
            settled: 0,
        }
    }

    /// Sets the trained range of a pre-fitted model.
    pub(super) fn set_range(&mut self, low: &[f64], high: &[f64]) {
        for (to, &from) in self.low.iter_mut().zip(low).chain(self.high.iter_mut().zip(high)) {
            *to = T::from_design(from);
        }
    }

    /// Whether the training has not seen anything like this input: it lies outside the range so far by
    /// more than the margins.
    pub(super) fn is_new(&self, u: &[T]) -> bool {
        !self.has_sample || self.is_beyond(u, T::one())
    }

    /// Widens the trained range by one sample.
    pub(super) fn learn(&mut self, u: &[T]) {
        let first = !self.has_sample;
        for ((low, high), &u) in self.low.iter_mut().zip(&mut self.high).zip(u) {
            *low = if first { u } else { low.min(u) };
            *high = if first { u } else { high.max(u) };
        }
        self.follow(u);
    }

    /// The widest trained range of all inputs.
    pub(super) fn span(&self) -> T {
        let spans = self.low.iter().zip(&self.high).map(|(&low, &high)| high - low);
        spans.fold(T::zero(), T::max)
    }

    /// Watches one sample and reports whether to train again.
    pub(super) fn watch(&mut self, u: &[T], events: &mut Events) -> bool {
        self.follow(u);
        if self.policy == RangePolicy::Ignore {
            return false;
        }
        let half = T::from_design(0.5);
        let was_outside = self.outside;
        self.outside = self.is_beyond(&self.slow, if was_outside { half } else { T::one() });
        match (was_outside, self.outside) {
            (false, true) => {
                events.push(EventKind::OperatingPointLeft);
                self.settled = 0;
                self.anchor.copy_from_slice(&self.slow);
            }
            (true, false) => events.push(EventKind::OperatingPointRegained),
            _ => {}
        }
        match self.policy {
            RangePolicy::Retrain => self.outside,
            RangePolicy::RetrainAfter { samples, .. } => self.outside && self.settles(samples),
            RangePolicy::Ignore | RangePolicy::Warn => false,
        }
    }

    /// Whether the input is outside the trained range.
    pub(super) fn is_outside(&self) -> bool {
        self.outside
    }

    fn follow(&mut self, u: &[T]) {
        let gain = if self.has_sample { self.gain } else { T::one() };
        for (slow, &u) in self.slow.iter_mut().zip(u) {
            *slow += gain * (u - *slow);
        }
        self.has_sample = true;
    }

    /// Whether an input is outside the trained range by more than `share` of its margins.
    fn is_beyond(&self, u: &[T], share: T) -> bool {
        self.low.iter().zip(&self.high).zip(u).any(|((&low, &high), &u)| {
            let margin = (self.margin * (high - low) + self.margin_absolute) * share;
            u < low - margin || high + margin < u
        })
    }

    fn settles(&mut self, samples: u64) -> bool {
        let ranges = self.low.iter().zip(&self.high).map(|(&low, &high)| high - low);
        let wanders =
            self.slow.iter().zip(&self.anchor).zip(ranges).any(|((&now, &then), range)| {
                (now - then).abs() > self.band * range + self.margin_absolute
            });
        if wanders {
            self.settled = 0;
            self.anchor.copy_from_slice(&self.slow);
        } else {
            self.settled += 1;
        }
        self.settled >= samples
    }

    /// Goes on learning the range where it ended.
    pub(super) fn reopen(&mut self) {
        self.outside = false;
        self.settled = 0;
    }

    pub(super) fn reset(&mut self) {
        for values in [&mut self.low, &mut self.high, &mut self.slow, &mut self.anchor] {
            values.fill(T::zero());
        }
        self.has_sample = false;
        self.outside = false;
        self.settled = 0;
    }

    pub(super) fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("trained input low", &mut self.low);
        visitor.reals("trained input high", &mut self.high);
        visitor.reals("low-passed input", &mut self.slow);
        visitor.reals("settling anchor", &mut self.anchor);
        let mut counts = [u64::from(self.has_sample), u64::from(self.outside), self.settled];
        visitor.counts("input seen, outside, settled", &mut counts);
        self.has_sample = counts[0] != 0;
        self.outside = counts[1] != 0;
        self.settled = counts[2];
    }
}
