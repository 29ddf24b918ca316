//! The mean of the residual since the first alarm.

use fd_core::{
    Scalar, StateVisitor,
    stage::{Evidence, Phase},
};

use super::{debounce::Debounce, error::RuleError};

/// Where an alarm stands.
pub(super) enum Alarm {
    /// Nothing is suspected.
    None,
    /// Too few samples have alarmed so far.
    Pending,
    /// A fault is reported.
    Raised {
        /// Sample of the first alarm.
        since: u64,
    },
}

/// Running mean that begins some samples after the first alarm and, with a memory, forgets.
#[derive(Clone, Debug)]
pub(super) struct FaultMean<T> {
    settling: u64,
    gain: Option<T>,
    mean: Vec<T>,
    /// Samples in the mean.
    averaged: u64,
    /// Samples since the first alarm.
    age: u64,
}

impl<T: Scalar> FaultMean<T> {
    pub(super) fn new(
        channels: usize,
        settling: u64,
        memory: Option<f64>,
    ) -> Result<Self, RuleError> {
        if let Some(found) = memory.filter(|m| !(*m >= 1.0 && m.is_finite())) {
            let (parameter, expected) = ("memory", "finite and at least 1 sample");
            return Err(RuleError::Number { parameter, expected, found });
        }
        let gain = memory.map(|m| T::from_design(m.recip()));
        Ok(Self { settling, gain, mean: vec![T::zero(); channels], averaged: 0, age: 0 })
    }

    pub(super) fn values(&self) -> &[T] {
        &self.mean
    }

    pub(super) fn is_empty(&self) -> bool {
        self.averaged == 0
    }

    /// Samples that the mean is worth if they are independent: with gain `1/M` at most `2 M − 1`.
    pub(super) fn worth(&self) -> T {
        let averaged = T::from_design(self.averaged as f64);
        let two = T::one() + T::one();
        self.gain.map_or(averaged, |gain| averaged.min(two / gain - T::one()))
    }

    pub(super) fn add(&mut self, r: &[T]) {
        self.age += 1;
        // A sample without a residual says nothing of its mean.
        if self.age <= self.settling || !r.iter().all(T::is_finite) {
            return;
        }
        self.averaged += 1;
        let plain = T::from_design((self.averaged as f64).recip());
        let gain = self.gain.map_or(plain, |gain| gain.max(plain));
        for (mean, &r) in self.mean.iter_mut().zip(r) {
            *mean += gain * (r - *mean);
        }
    }

    /// Lets an alarm judge a sample, and takes the sample in where it belongs to the fault.
    pub(super) fn follow(&mut self, alarm: &mut Debounce, evidence: Evidence<'_, T>) -> Alarm {
        let Evidence { k, phase, verdict, r_star } = evidence;
        let Some(since) = alarm.judge(k, phase, verdict.alarm()) else {
            if alarm.pending(k).is_none() {
                return Alarm::None;
            }
            // It may yet be raised, and then these samples count.
            self.add(r_star);
            return Alarm::Pending;
        };
        if phase == Phase::Compensating {
            self.add(r_star);
        }
        Alarm::Raised { since }
    }

    pub(super) fn forget(&mut self) {
        self.mean.fill(T::zero());
        self.averaged = 0;
        self.age = 0;
    }

    pub(super) fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("fault mean residual", &mut self.mean);
        let mut counts = [self.averaged, self.age];
        visitor.counts("fault averaged, age", &mut counts);
        [self.averaged, self.age] = counts;
    }
}
