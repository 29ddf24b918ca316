//! A simulator outside of this program, as a simulator.

mod foresight;
mod host;
mod lanes;
mod repeat;
mod replay;
mod settle;
mod simulate;
mod work;

use std::sync::{Arc, OnceLock};

use super::{
    contract::Contract,
    disposable::Disposables,
    error::OutsideError,
    grain::Grain,
    loan::{Fate, Loan, Shared},
    memory::{Memory, Past},
    pool::Pool,
    source::{Lost, Source, Start},
    tally::{Counts, Tally},
    tapes::{Foreseen, Tapes},
};
use crate::simulate::{Shell, SimulateError, Simulator};

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

impl Drop for OutsideSimulator {
    fn drop(&mut self) {
        self.rest();
    }
}
