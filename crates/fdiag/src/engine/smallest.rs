//! The smallest fault that a detector finds in a given run.

use fd_core::{
    Scalar,
    stage::{Decision, DecisionRule, Detector, Evidence, Phase},
};

/// Relative accuracy of the smallest size.
const ACCURACY: f64 = 1e-3;

/// Detector and rule that look at given residuals; they are restarted for each look.
pub(super) struct Watch {
    detector: Box<dyn Detector>,
    rule: Box<dyn DecisionRule>,
}

/// A fault-free residual and what a fault of size 1 adds to it, sample by sample and channel by
/// channel: with a linear generator and a compensation that only looks at `u`, the residual of a
/// fault of size `s` is `r + s φ` exactly.
pub(super) struct FaultRun<'a> {
    pub(super) r: &'a [f64],
    pub(super) phi: &'a [f64],
    /// First sample of the fault.
    pub(super) start: usize,
}

impl Watch {
    pub(super) fn new(detector: Box<dyn Detector>, rule: Box<dyn DecisionRule>) -> Self {
        Self { detector, rule }
    }

    /// First sample with a reported fault.
    pub(super) fn first_alarm(&mut self, run: &FaultRun<'_>, size: f64) -> Option<usize> {
        self.detector.reset();
        self.rule.reset();
        let channels = self.detector.residual_len();
        let mut row = vec![f64::zero(); channels];
        let rows = run.r.chunks_exact(channels).zip(run.phi.chunks_exact(channels));
        for (k, (r, phi)) in rows.enumerate() {
            for ((row, r), phi) in row.iter_mut().zip(r).zip(phi) {
                *row = r + size * phi;
            }
            let verdict = self.detector.update(&row);
            let phase = Phase::Compensating;
            let evidence = Evidence { k: k as u64, phase, verdict, r_star: &row };
            if let Decision::Fault(_) = self.rule.decide(evidence) {
                return Some(k);
            }
        }
        None
    }

    /// Smallest size of the given sign that raises an alarm after the fault began, up to `most`;
    /// `None` when `most` is not enough, or when the run alarms without any fault.
    pub(super) fn smallest(&mut self, run: &FaultRun<'_>, sign: f64, most: f64) -> Option<f64> {
        if self.first_alarm(run, 0.0).is_some() {
            return None;
        }
        let mut found =
            |size: f64| self.first_alarm(run, sign * size).is_some_and(|k| k >= run.start);
        // From far below upwards, so that the smallest is found although a larger fault may
        // cancel what a smaller one shows.
        let mut high = most * 1e-6;
        while !found(high) {
            high *= 1.5;
            if high > most {
                return None;
            }
        }
        let mut low = high / 1.5;
        while high - low > ACCURACY * high {
            let middle = 0.5 * (low + high);
            if found(middle) { high = middle } else { low = middle }
        }
        Some(high)
    }
}
