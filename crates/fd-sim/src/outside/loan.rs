//! A simulator from the pool, for the run of one copy.

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, MutexGuard, OnceLock},
    time::Instant,
};

use super::{
    contract::Contract,
    error::OutsideError,
    grain::Grain,
    lock::open,
    memory::{Memory, Past},
    pool::{Lease, Pool},
    source::{Instance, Lost, Source},
    spread::Spread,
    tally::Tally,
    tapes::Tapes,
};
use crate::simulate::DifferenceEquation;

/// So many deaths at the same parameters are a divergence there.
const MOST_DEATHS: u32 = 3;
/// A silence costs its whole limit, so the second one is the last.
const SILENCE: u32 = 2;
/// So often it is tried to start another simulator before all is given up.
const STARTS: usize = 2;

/// What all copies of a simulator share.
#[derive(Debug)]
pub(super) struct Shared {
    pub contract: Contract,
    /// Before the source: what it keeps for them is there until they have ended.
    pub pool: Pool,
    pub source: Arc<dyn Source>,
    /// What was simulated before; none where everything is to be simulated.
    pub memory: Option<Memory>,
    pub tally: Arc<Tally>,
    pub grain: Grain,
    /// By how much equal runs differ; none where they do not, or nobody has looked.
    pub spread: OnceLock<Spread>,
    /// Inputs that were gone through before.
    pub tapes: Tapes,
    /// How outputs change with inputs and forces, where somebody has told.
    pub responses: Mutex<Option<Arc<[DifferenceEquation]>>>,
    /// Deaths by parameters and initial states; and whether all is given up.
    pub fate: Mutex<Fate>,
}

/// What is known of parameters at which simulators end.
#[derive(Debug, Default)]
pub(super) struct Fate {
    deaths: HashMap<Past, u32>,
    is_over: bool,
}

/// How a piece of work ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Work {
    Done,
    /// The simulator says that the run diverges here.
    Refused,
    /// Lost for reasons that are not in the numbers; not to be remembered.
    Lost,
}

/// The simulator that a copy has, and how many samples of the present run it has made; `None` when it has not
/// begun.
#[derive(Debug, Default)]
pub(super) struct Loan {
    lease: Option<Lease>,
    reached: Option<usize>,
}

impl Loan {
    /// The simulator of this copy has not begun the next run.
    pub(super) fn begin(&mut self) {
        self.reached = None;
    }

    /// Gives the simulator back.
    pub(super) fn end(&mut self, pool: &Pool) {
        if let Some(lease) = self.lease.take() {
            pool.give_back(lease);
        }
        self.reached = None;
    }

    /// Does a piece of work of the run that starts at `origin`. When the simulator ends, another one does it.
    /// The work is told how many samples are made, and says so when it is done.
    pub(super) fn work(
        &mut self,
        shared: &Shared,
        origin: Past,
        mut act: impl FnMut(&mut dyn Instance, &mut Option<usize>) -> Result<(), Lost>,
    ) -> Work {
        loop {
            if shared.is_hopeless(origin) {
                Tally::add(&shared.tally.lost, 1);
                return Work::Lost;
            }
            let held = self.lease.and_then(|lease| Some((lease, shared.pool.slot(lease)?)));
            let Some((lease, mut slot)) = held else {
                (self.lease, self.reached) = (Some(shared.pool.lease()), None);
                continue;
            };
            if slot.instance.is_none() {
                self.reached = None;
                slot.instance = shared.start();
            }
            let Some(instance) = slot.instance.as_deref_mut() else {
                drop(slot);
                shared.pool.give_back(lease);
                continue;
            };
            let begun = Instant::now();
            let done = act(instance, &mut self.reached);
            shared.tally.inside(begun.elapsed());
            match done {
                Ok(()) => return Work::Done,
                Err(Lost::Refused) => {
                    self.reached = None;
                    return Work::Refused;
                }
                Err(lost) => {
                    (slot.instance, self.reached) = (None, None);
                    drop(slot);
                    shared.bury(origin, lost);
                }
            }
        }
    }
}

impl Shared {
    /// Writes what is remembered of a past into these parts, if anything is.
    pub(super) fn recall(&self, past: Past, parts: [&mut [f64]; 2]) -> bool {
        self.memory.as_ref().is_some_and(|memory| memory.recall(past, parts))
    }

    /// Remembers the results of a past, unless the work was lost.
    pub(super) fn keep(&self, past: Past, parts: [&[f64]; 2], work: Work) {
        self.grain.look(parts[0]);
        if let Some(memory) = self.memory.as_ref().filter(|_| work != Work::Lost) {
            memory.keep(past, parts);
        }
    }

    fn fate(&self) -> MutexGuard<'_, Fate> {
        open(&self.fate)
    }

    fn is_hopeless(&self, origin: Past) -> bool {
        let fate = self.fate();
        fate.is_over || fate.deaths.get(&origin).is_some_and(|deaths| MOST_DEATHS <= *deaths)
    }

    pub(super) fn is_given_up(&self) -> bool {
        self.fate().is_over
    }

    /// Starts a simulator; gives all up where that fails again.
    fn start(&self) -> Option<Box<dyn Instance>> {
        for _ in 0..STARTS {
            match self.source.open() {
                Ok(instance) => {
                    Tally::add(&self.tally.started, 1);
                    return Some(instance);
                }
                Err(error) => self.tally.note(error),
            }
        }
        self.fate().is_over = true;
        None
    }

    /// Notes why a simulator is no more.
    fn bury(&self, origin: Past, lost: Lost) {
        Tally::add(&self.tally.deaths, 1);
        let mut fate = self.fate();
        let error = match lost {
            Lost::Refused => return,
            Lost::Gone(error) => {
                let weight =
                    if matches!(*error, OutsideError::Silent { .. }) { SILENCE } else { 1 };
                *fate.deaths.entry(origin).or_default() += weight;
                error
            }
            Lost::Broken(error) => {
                fate.is_over = true;
                error
            }
        };
        self.tally.note(*error);
    }
}
