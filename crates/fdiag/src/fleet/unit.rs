//! The memory of one unit of a fleet.

use fd_core::{
    Scalar, StateVisitor,
    stage::{Decision, DecisionRule, Detector, Evidence, Phase, Verdict},
};

/// How one unit of a fleet is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitStatus<T> {
    /// Samples so far, missing ones included.
    pub samples: u64,
    /// Samples of which something was missing.
    pub missing: u64,
    /// Whether the bias is being learned or subtracted.
    pub phase: Phase,
    /// Statistic of the last sample that was judged.
    pub verdict: Option<Verdict<T>>,
    /// What the rule made of it.
    pub decision: Decision<T>,
}

/// Detector, rule and counts of one unit.
#[derive(Clone, Debug)]
pub(super) struct Unit<T, D, J> {
    detector: D,
    rule: J,
    pub samples: u64,
    pub missing: u64,
    /// Complete samples seen by the generator, counted up to the settling time.
    pub settled: u64,
    /// Samples that were offered to the learner.
    pub offered: u64,
    /// Samples that it has learned from.
    pub learned: u64,
    pub is_frozen: bool,
    verdict: Option<Verdict<T>>,
    decision: Decision<T>,
}

impl<T: Scalar, D: Detector<T>, J: DecisionRule<T>> Unit<T, D, J> {
    pub(super) fn new(detector: D, rule: J) -> Self {
        Self {
            detector,
            rule,
            samples: 0,
            missing: 0,
            settled: 0,
            offered: 0,
            learned: 0,
            is_frozen: false,
            verdict: None,
            decision: Decision::Nominal,
        }
    }

    pub(super) fn judge(&mut self, u: &[T], r_star: &[T]) {
        let verdict = self.detector.update(u, r_star);
        let phase = Phase::Compensating;
        self.decision = self.rule.decide(Evidence { k: self.samples, phase, verdict, r_star });
        self.verdict = Some(verdict);
    }

    pub(super) fn status(&self) -> UnitStatus<T> {
        let phase = if self.is_frozen {
            Phase::Compensating
        } else {
            Phase::Training { samples: self.learned }
        };
        let Self { samples, missing, verdict, decision, .. } = *self;
        UnitStatus { samples, missing, phase, verdict, decision }
    }

    pub(super) fn reset(&mut self) {
        self.detector.reset();
        self.rule.reset();
        (self.samples, self.missing, self.settled) = (0, 0, 0);
        (self.offered, self.learned, self.is_frozen) = (0, 0, false);
        (self.verdict, self.decision) = (None, Decision::Nominal);
    }

    pub(super) fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        self.detector.visit_state(visitor);
        self.rule.visit_state(visitor);
        let mut counts = [
            self.samples,
            self.missing,
            self.settled,
            self.offered,
            self.learned,
            u64::from(self.is_frozen),
        ];
        visitor.counts("unit samples, missing, settled, offered, learned, frozen", &mut counts);
        let is_frozen;
        [self.samples, self.missing, self.settled, self.offered, self.learned, is_frozen] = counts;
        self.is_frozen = is_frozen != 0;
    }
}
