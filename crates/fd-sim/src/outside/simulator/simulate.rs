//! How it is simulated: from a memory where that was done before, by steps, or by whole runs.

use std::sync::Arc;

use fd_model::{Channel, SampleTime};

use super::{
    super::{
        loan::{Loan, Shared, Work},
        lock::open,
        memory::Past,
        tally::Tally,
        tapes::Foreseen,
    },
    OutsideSimulator, lanes, replay, settle,
};
use crate::{
    model::Parameter,
    simulate::{
        DifferenceEquation, Driven, Initial, NativeEffect, Outcome, Port, Run, Simulator, Tape,
        as_tapes,
    },
};

/// What distinguishes a measurement from a step in the past of a run, and a whole run from both.
const MEASURED: u64 = 0x6d65_6173;

impl Simulator for OutsideSimulator {
    fn ts(&self) -> SampleTime {
        self.shared.contract.ts
    }

    fn inputs(&self) -> &[Channel] {
        &self.shared.contract.inputs
    }

    fn outputs(&self) -> &[Channel] {
        &self.shared.contract.outputs
    }

    fn parameters(&self) -> &[Parameter] {
        &self.shared.contract.parameters
    }

    fn natives(&self) -> &[NativeEffect] {
        &self.shared.contract.natives
    }

    fn initial(&self) -> &[Initial] {
        &self.shared.contract.initial
    }

    fn ports(&self) -> &[Port] {
        &self.shared.contract.ports
    }

    fn start(&mut self, theta: &[f64], x0: &[f64], first: u64) {
        self.theta.clear();
        self.theta.extend_from_slice(theta);
        self.x0.clear();
        self.x0.extend_from_slice(x0);
        self.first = first;
        self.origin = Past::default().and(theta).and(x0);
        self.past = self.origin.with(first);
        self.tape.clear();
        self.samples = 0;
        self.foreseen = Foreseen::default();
        (self.has_diverged, self.was_made) = (false, false);
        if !self.x.is_empty() {
            self.x.copy_from_slice(x0);
        }
        self.loan.begin();
    }

    fn step(&mut self, u: &[f64], _u_next: &[f64], f: &[f64], y: &mut [f64]) {
        if self.has_diverged {
            y.fill(f64::NAN);
            return;
        }
        if self.samples == 0 && self.shared.contract.powers.step {
            Tally::add(&self.shared.tally.asked, 1);
        }
        self.note_row(u, f);
        self.foreseen.follow(self.samples, &self.row);
        let past = self.past.and(&self.row);
        if !self.shared.recall(past, [y, &mut self.x]) {
            let work = self.advance(y);
            if work != Work::Done {
                y.fill(f64::NAN);
            }
            self.shared.keep(past, [y, &self.x], work);
        }
        self.past = past;
        self.tape.extend_from_slice(&self.row);
        self.samples += 1;
        if y.iter().any(|value| !value.is_finite()) {
            y.fill(f64::NAN);
            self.has_diverged = true;
            self.rest();
        }
    }

    fn measure(&mut self, u: &[f64], y: &mut [f64]) -> bool {
        let powers = self.shared.contract.powers;
        if powers.step && !powers.measure {
            return false;
        }
        if self.has_diverged {
            y.fill(f64::NAN);
            return true;
        }
        let past = self.past.with(MEASURED).and(u);
        if !self.shared.recall(past, [y, &mut []]) {
            let work = if powers.step {
                self.work(|instance, _| instance.measure(u, y).map(|()| 0))
            } else {
                // A whole run up to here, without forces now.
                self.note_row(u, &[]);
                self.foreseen.follow(self.samples, &self.row);
                self.advance(y)
            };
            if work != Work::Done {
                y.fill(f64::NAN);
            }
            self.shared.keep(past, [y, &[]], work);
        }
        true
    }

    /// Where the simulator does not show its states, those that the run has begun with.
    fn state(&self) -> &[f64] {
        if self.shared.contract.powers.states { &self.x } else { &self.x0 }
    }

    fn boxed(&self) -> Box<dyn Simulator> {
        Box::new(Self {
            shared: Arc::clone(&self.shared),
            loan: Loan::default(),
            theta: self.theta.clone(),
            x0: self.x0.clone(),
            first: self.first,
            origin: self.origin,
            past: self.past,
            tape: self.tape.clone(),
            samples: self.samples,
            row: Vec::new(),
            x: self.x.clone(),
            foreseen: Foreseen::default(),
            has_diverged: self.has_diverged,
            was_made: self.was_made,
        })
    }

    fn simulate(&mut self, theta: &[f64], x0: &[f64], u: &[f64], y: &mut [f64]) -> Outcome {
        let mut runs = [Run::new(theta, x0, y)];
        self.simulate_many(0, u, &mut runs);
        runs[0].outcome
    }

    fn simulate_many(&mut self, first: u64, u: &[f64], runs: &mut [Run<'_>]) {
        as_tapes(self, u, runs, |simulator, tapes| simulator.replay(first, tapes));
    }

    fn replay(&mut self, first: u64, tapes: &mut [Tape<'_>]) {
        replay::replay(self, first, tapes);
    }

    fn lock_step(&mut self, first: u64, lanes: &mut [Box<dyn Driven + '_>]) {
        lanes::lock_step(self, first, lanes);
    }

    fn makes_steps(&self) -> bool {
        self.shared.contract.powers.step
    }

    fn foretell(&self, responses: &Arc<[DifferenceEquation]>) {
        *open(&self.shared.responses) = Some(Arc::clone(responses));
    }

    /// What it says, or what its outputs look like; where it does not repeat itself, what differs; where runs have to
    /// settle, how far.
    fn precision(&self) -> f64 {
        let Shared { contract, grain, .. } = &*self.shared;
        let said = contract.powers.precision.unwrap_or_else(|| grain.precision());
        let said = if contract.powers.step { said } else { said.max(settle::SETTLED) };
        self.measured_spread().map_or(said, |spread| said.max(spread.relative))
    }

    fn spread(&self) -> &[f64] {
        self.measured_spread().map_or(&[], |spread| &spread.deviation)
    }

    fn repeats(&self) -> bool {
        self.measured_spread().is_none()
    }

    fn workers(&self) -> usize {
        self.shared.pool.workers()
    }

    fn rest(&mut self) {
        let Self { shared, loan, .. } = self;
        loan.end(&shared.pool);
    }
}
