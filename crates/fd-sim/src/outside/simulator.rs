//! A simulator outside of this program, as a simulator.

mod foresight;
mod host;
mod lanes;
mod repeat;
mod replay;
mod settle;
mod work;

use std::sync::{Arc, OnceLock};

use fd_model::{Channel, SampleTime};

use self::foresight::Foreseen;
pub(super) use self::foresight::Tapes;
pub use self::repeat::Spread;
use super::{
    contract::Contract,
    disposable::Disposables,
    error::OutsideError,
    grain::Grain,
    loan::{Fate, Loan, Shared, Work},
    lock::open,
    memory::{Memory, Past},
    pool::Pool,
    source::{Lost, Source, Start},
    tally::{Counts, Tally},
};
use crate::{
    model::Parameter,
    simulate::{
        DifferenceEquation, Driven, Initial, NativeEffect, Outcome, Port, Run, Shell,
        SimulateError, Simulator, Tape, as_tapes,
    },
};

/// What distinguishes a measurement from a step in the past of a run, and a whole run from both.
const MEASURED: u64 = 0x6d65_6173;
const WHOLE: u64 = 0x7768_6f6c;

/// A simulator outside of this program: a process or an FMU.
///
/// Copies share a pool of running simulators, one of which a copy has from its first step on until its run is
/// over; making a copy costs nothing. Steps and runs that were made before are answered from a memory. Who
/// copies it in the middle of a run, or finds that others needed its simulator, repeats the run up to there:
/// it is the same, to the bit.
///
/// A simulator that ends or is silent for too long is started again and the run repeated; three deaths at the
/// same parameters and initial states, or two silences, are a divergence there. One that breaks its contract
/// is given up. What went wrong is in [`trouble`](Self::trouble), how much was asked in
/// [`counts`](Self::counts).
#[derive(Debug)]
pub struct OutsideSimulator {
    shared: Arc<Shared>,
    loan: Loan,
    theta: Vec<f64>,
    x0: Vec<f64>,
    first: u64,
    /// Parameters and initial states.
    origin: Past,
    /// All that the next sample depends on.
    past: Past,
    /// Inputs and forces of the samples so far, row by row.
    tape: Vec<f64>,
    samples: usize,
    row: Vec<f64>,
    x: Vec<f64>,
    foreseen: Foreseen,
    has_diverged: bool,
    /// Whether any simulator has begun this run.
    was_made: bool,
}

impl OutsideSimulator {
    /// A simulator with at most `workers` instances of the source, of which one is started, to see that it can
    /// be, and begins a run at the nominal parameters.
    ///
    /// # Errors
    ///
    /// Returns why it cannot be started.
    pub fn new(
        contract: Contract,
        source: impl Source + 'static,
        workers: usize,
    ) -> Result<Self, OutsideError> {
        let theta: Vec<f64> = contract.parameters.iter().map(|p| p.value).collect();
        let x0: Vec<f64> = contract.initial.iter().map(|state| state.value).collect();
        let (tally, mut source): (_, Arc<dyn Source>) = (Arc::<Tally>::default(), Arc::new(source));
        if !contract.powers.resets && !source.renews() {
            source = Arc::new(Disposables { source, tally: Arc::clone(&tally) });
        }
        let mut first = source.open()?;
        match first.reset(Start { theta: &theta, x0: &x0, first: 0 }) {
            // What the nominal parameters do is for whoever asks for a run to find.
            Ok(()) | Err(Lost::Refused) => {}
            Err(Lost::Gone(error) | Lost::Broken(error)) => return Err(*error),
        }
        Tally::add(&tally.started, 1);
        let shared = Shared {
            contract,
            source,
            pool: Pool::new(workers),
            memory: Some(Memory::default()),
            tally,
            grain: Grain::default(),
            spread: OnceLock::new(),
            tapes: Tapes::default(),
            responses: None.into(),
            fate: Fate::default().into(),
        };
        shared.pool.fill(first);
        Ok(Self::of(Arc::new(shared)))
    }

    /// The same, asking for every run, also for one that was made before. Of a simulator that has no copies.
    #[must_use]
    pub fn without_memory(mut self) -> Self {
        if let Some(shared) = Arc::get_mut(&mut self.shared) {
            shared.memory = None;
        }
        self
    }

    fn of(shared: Arc<Shared>) -> Self {
        let states = if shared.contract.powers.states { shared.contract.initial.len() } else { 0 };
        Self {
            shared,
            loan: Loan::default(),
            theta: Vec::new(),
            x0: Vec::new(),
            first: 0,
            origin: Past::default(),
            past: Past::default(),
            tape: Vec::new(),
            samples: 0,
            row: Vec::new(),
            x: vec![0.0; states],
            foreseen: Foreseen::default(),
            has_diverged: false,
            was_made: false,
        }
    }

    /// The shell around it, with the noise and the motion that its contract tells of.
    ///
    /// # Errors
    ///
    /// Returns an error when the contract has no outputs, a value out of order, or a motion that is no output.
    pub fn shell(&self) -> Result<Shell, SimulateError> {
        let contract = self.contract();
        let mut shell = Shell::new(&contract.name, self.boxed())?.with_noise(&contract.noise);
        for (port, motion) in contract.ports.iter().zip(&contract.motion) {
            let [position, velocity] = [&motion.position, &motion.velocity].map(Option::as_deref);
            shell = shell.with_motion(&port.channel.name, position, velocity)?;
        }
        Ok(shell)
    }

    /// What the simulator is.
    #[must_use]
    pub fn contract(&self) -> &Contract {
        &self.shared.contract
    }

    /// What was asked so far, of this and all its copies.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.shared.tally.counts()
    }

    /// What was found out about it while it ran, and its user should know.
    #[must_use]
    pub fn note(&self) -> Option<String> {
        self.shared.source.note()
    }

    /// What went wrong last, with this or any of its copies.
    #[must_use]
    pub fn trouble(&self) -> Option<OutsideError> {
        self.shared.tally.trouble()
    }
}

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

impl Drop for OutsideSimulator {
    fn drop(&mut self) {
        self.rest();
    }
}
