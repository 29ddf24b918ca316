//! What a detector remembers when the switch opens.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use fd_core::{
    Events, Frame, Pipeline, Snapshot, Stages, StateVisitor,
    stage::{Compensation, Compensator, Detector, Phase, Stage, Verdict},
};

use crate::smallest::{AlarmIsFault, Lag};

/// Trains for so many samples, in which `r* = r`, and leaves a hundredth of the residual afterwards.
#[derive(Clone, Debug)]
struct Opens {
    after: u64,
    seen: u64,
}

impl Stage for Opens {
    fn reset(&mut self) {
        self.seen = 0;
    }
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
        visitor.counts("seen", std::slice::from_mut(&mut self.seen));
    }
}

impl Compensator for Opens {
    fn nu(&self) -> Option<usize> {
        None
    }
    fn residual_len(&self) -> usize {
        1
    }
    fn step(&mut self, _: Frame<'_, f64>, r: &[f64], r_star: &mut [f64]) -> Compensation {
        self.seen += 1;
        let trains = self.seen <= self.after;
        r_star[0] = if trains { r[0] } else { 0.01 * r[0] };
        let phase =
            if trains { Phase::Training { samples: self.seen } } else { Phase::Compensating };
        Compensation { phase, events: Events::none() }
    }
}

/// The sum of magnitudes since it began.
#[derive(Clone, Debug)]
struct Sum(f64);

impl Stage for Sum {
    fn reset(&mut self) {
        self.0 = 0.0;
    }
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
        visitor.reals("sum", std::slice::from_mut(&mut self.0));
    }
}

impl Detector for Sum {
    fn residual_len(&self) -> usize {
        1
    }
    fn update(&mut self, _u: &[f64], r: &[f64]) -> Verdict<f64> {
        self.0 += r[0].abs();
        Verdict { statistic: self.0, threshold: 0.5 }
    }
}

/// Residuals of the training are large and stay out of the verdicts after it, also in a copy that was restored
/// while it trained, and after a reset; what was compensated is remembered, also by a copy.
#[test]
fn a_detector_begins_with_the_first_compensated_sample() {
    let new = || {
        Pipeline::new(Stages {
            generator: Lag { previous: 0.0 },
            compensator: Opens { after: 4, seen: 0 },
            detector: Sum(0.0),
            rule: AlarmIsFault,
        })
        .unwrap()
    };
    for restored_at in [None, Some(0), Some(3), Some(4), Some(5)] {
        let mut pipeline = new();
        for _ in 0..2 {
            for k in 0..8_u32 {
                if restored_at == Some(k) {
                    let mut other = new();
                    Snapshot::of(&mut pipeline).restore(&mut other).unwrap();
                    pipeline = other;
                }
                let statistic = pipeline.step(&[0.0], &[1.0]).unwrap().verdict.statistic;
                // The residual of `Lag` under constant signals is one at first and a half from then on.
                let seen = if k < 4 { 1.0 + 0.5 * f64::from(k) } else { 0.005 * f64::from(k - 3) };
                assert!(
                    (statistic - seen).abs() < 1e-12,
                    "sample {k}, restored at {restored_at:?}"
                );
            }
            pipeline.reset();
        }
    }
}
