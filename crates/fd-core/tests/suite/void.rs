//! A detector that knows where its threshold states no rate, within a pipeline.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use fd_core::{
    EventKind, Pipeline, Snapshot, Stages, StateVisitor,
    stage::{Detector, Stage, Uncompensated, Verdict},
};

use crate::smallest::{AlarmIsFault, Lag};

/// Void while the input is above one.
#[derive(Clone, Debug)]
struct Knows {
    u: f64,
}

impl Stage for Knows {
    fn reset(&mut self) {
        self.u = 0.0;
    }
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
        visitor.reals("u", std::slice::from_mut(&mut self.u));
    }
}

impl Detector for Knows {
    fn residual_len(&self) -> usize {
        1
    }
    fn update(&mut self, u: &[f64], _r: &[f64]) -> Verdict<f64> {
        self.u = u[0];
        Verdict { statistic: 0.0, threshold: 1.0 }
    }
    fn is_void(&self) -> bool {
        self.u > 1.0
    }
}

/// Said once when it begins and once when it ends, also by a restored copy, and without an alarm.
#[test]
fn a_void_threshold_is_told_by_events() {
    let new = || {
        Pipeline::new(Stages {
            generator: Lag { previous: 0.0 },
            compensator: Uncompensated::new(1),
            detector: Box::new(Knows { u: 0.0 }) as Box<dyn Detector>,
            rule: AlarmIsFault,
        })
        .unwrap()
    };
    let mut pipeline = new();
    let mut said = Vec::new();
    for (k, u) in [0.0, 2.0, 2.0, 2.0, 0.5, 0.5, 3.0].into_iter().enumerate() {
        if k == 3 {
            let mut other = new();
            Snapshot::of(&mut pipeline).restore(&mut other).unwrap();
            pipeline = other;
        }
        let step = pipeline.step(&[u], &[0.0]).unwrap();
        assert!(!step.decision.is_fault());
        said.extend(step.events.iter().map(|kind| (step.k, kind)));
    }
    let (void, valid) = (EventKind::ThresholdVoid, EventKind::ThresholdValid);
    assert_eq!(said, [(1, void), (4, valid), (6, void)]);
}
