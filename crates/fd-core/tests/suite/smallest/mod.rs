//! The smallest generator and the smallest rule.

use fd_core::{
    Frame, IoDims, StateVisitor,
    stage::{Decision, DecisionRule, Evidence, Fault, ResidualGenerator, Stage},
};

/// `r = y − a·(previous y) − u`: the smallest generator with a memory.
#[derive(Clone, Debug)]
pub(crate) struct Lag {
    pub(crate) previous: f64,
}

impl Stage for Lag {
    fn reset(&mut self) {
        self.previous = 0.0;
    }
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
        visitor.reals("previous", std::slice::from_mut(&mut self.previous));
    }
}

impl ResidualGenerator for Lag {
    fn io(&self) -> IoDims {
        IoDims { nu: 1, ny: 1 }
    }
    fn residual_len(&self) -> usize {
        1
    }
    fn step(&mut self, frame: Frame<'_, f64>, r: &mut [f64]) {
        r[0] = frame.y()[0] - 0.5 * self.previous - frame.u()[0];
        self.previous = frame.y()[0];
    }
}

/// Every alarm is a fault.
#[derive(Clone, Debug)]
pub(crate) struct AlarmIsFault;

impl Stage for AlarmIsFault {
    fn reset(&mut self) {}
    fn visit_state(&mut self, _: &mut dyn StateVisitor<f64>) {}
}

impl DecisionRule for AlarmIsFault {
    fn residual_len(&self) -> usize {
        1
    }
    fn decide(&mut self, evidence: Evidence<'_, f64>) -> Decision<f64> {
        if evidence.verdict.alarm() {
            Decision::Fault(Fault::since(evidence.k))
        } else {
            Decision::Nominal
        }
    }
}
