//! Detector and rule of a run that is only looked at.

use fd_core::{
    StateVisitor,
    stage::{Decision, DecisionRule, Detector, Evidence, Stage, Verdict},
};

/// Never alarms, over as many residual channels as it says.
#[derive(Clone, Copy, Debug)]
pub(super) struct Silent(pub(super) usize);

impl Stage for Silent {
    fn reset(&mut self) {}

    fn visit_state(&mut self, _visitor: &mut dyn StateVisitor<f64>) {}
}

impl Detector for Silent {
    fn residual_len(&self) -> usize {
        self.0
    }

    fn update(&mut self, _u: &[f64], _r: &[f64]) -> Verdict<f64> {
        Verdict { statistic: 0.0, threshold: 0.0 }
    }
}

impl DecisionRule for Silent {
    fn residual_len(&self) -> usize {
        self.0
    }

    fn decide(&mut self, _evidence: Evidence<'_, f64>) -> Decision<f64> {
        Decision::Nominal
    }
}
