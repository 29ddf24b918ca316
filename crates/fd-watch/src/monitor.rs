//! Many units, one diagnosis each.

use std::collections::HashMap;

use crate::{
    alarms::Floods,
    input::{Row, Runs},
    memory::{LearnedRows, MemoryError, UnitMemory},
    message::{Event, Message, What},
    plan::{Plan, PlanError},
    unit::{Unit, UnitStatus},
};

/// Takes rows and says what they mean. It has no thread, no clock and no file: the same rows give the same
/// messages to the bit, and a monitor that was restored goes on as one that was never stopped.
///
/// ```
/// # use fd_model::file::LinearModel;
/// use fd_watch::{Learning, Message, Monitor, Request, Row, What};
///
/// # let text = r#"
/// # version = 1
/// # kind = "state-space"
/// # sample_time = 1.0
/// # inputs = [{ name = "u" }]
/// # outputs = [{ name = "y" }]
/// # matrices = { A = [[0.9]], B = [[0.1]], C = [[1.0]], D = [[0.0]] }
/// # "#;
/// let model = LinearModel::parse("model.toml", text)?;
/// let mut monitor = Monitor::new(Request::new(model, Learning::Stream { samples: 600 }).plan()?);
/// for time in [0.0, 1.0, 2.0, 2.0] {
///     monitor.take(Row { unit: "p1", time, values: &[0.5, 0.1] })?;
/// }
/// let [Message::Event(began), Message::Event(doubled)] = &monitor.take_messages()[..] else { panic!() };
/// assert_eq!(began.what, What::LearningStarted { samples: 600 });
/// assert_eq!(doubled.what, What::Doubled { count: 1, ended: false });
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Monitor {
    plan: Plan,
    units: Vec<Unit>,
    names: HashMap<String, usize>,
    /// Units with something to be saved, in the order in which it happened.
    dirty: std::collections::VecDeque<usize>,
    refused: Runs,
    floods: Floods,
    messages: Vec<Message>,
    counts: Counts,
}

/// What went through a monitor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Rows taken.
    pub rows: u64,
    /// Rows of units that were refused.
    pub refused: u64,
    /// Rows dropped for their time: doubled, late, of a clock that went back or jumped.
    pub dropped: u64,
    /// Alarms raised.
    pub alarms: u64,
    /// Events told.
    pub events: u64,
}

impl Monitor {
    /// A monitor that has seen nothing yet.
    #[must_use]
    pub fn new(plan: Plan) -> Self {
        Self {
            plan,
            units: Vec::new(),
            names: HashMap::new(),
            dirty: std::collections::VecDeque::new(),
            refused: Runs::default(),
            floods: Floods::default(),
            messages: Vec::new(),
            counts: Counts::default(),
        }
    }

    /// What it goes by.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Puts back a unit that was saved; rows that are not newer than its memory will be left out.
    ///
    /// # Errors
    ///
    /// Returns an error when the memory is damaged or belongs to another plan.
    pub fn restore(
        &mut self,
        memory: UnitMemory,
        learned: Option<LearnedRows>,
    ) -> Result<(), MemoryError> {
        let unit = memory.restored(&self.plan, learned)?;
        let index = self.names.get(&unit.name).copied();
        if let Some(index) = index {
            self.units[index] = unit;
        } else {
            self.names.insert(unit.name.clone(), self.units.len());
            self.units.push(unit);
        }
        Ok(())
    }

    /// The source of the rows begins anew somewhere before where it was, as a broker does when a connection is made
    /// again: rows that are not newer than what was taken are no surprise, and left out.
    pub fn resume(&mut self) {
        for unit in &mut self.units {
            unit.clock.resume();
        }
    }

    /// Takes a row.
    ///
    /// # Errors
    ///
    /// Returns an error when the diagnosis of a new unit cannot be made, which is so for every unit or for
    /// none.
    pub fn take(&mut self, row: Row<'_>) -> Result<(), PlanError> {
        self.counts.rows += 1;
        let before = self.messages.len();
        let Some(index) = self.index(row.unit)? else {
            self.counts.refused += 1;
            return Ok(());
        };
        let unit = &mut self.units[index];
        if !unit.is_dirty {
            self.dirty.push_back(index);
        }
        unit.take(&self.plan, row.time, row.values, &mut self.messages);
        self.counts.dropped += std::mem::take(&mut unit.clock.dropped);
        self.flood(before, row.time);
        self.count(before);
        Ok(())
    }

    /// Tells of alarms that many units have in common, after those that were raised by now.
    fn flood(&mut self, from: usize, time: f64) {
        let settings = &self.plan.alarms;
        let mut told = Vec::new();
        for message in &self.messages[from..] {
            if let Message::Alarm(alarm) = message {
                told.extend(self.floods.raised(settings, alarm));
            }
        }
        if !self.floods.is_empty() {
            told.extend(self.floods.pass(settings, time));
        }
        self.messages.extend(told.into_iter().map(Message::Event));
    }

    /// Answers the question whether to train a unit again, and returns the unit; none when no such question waits.
    /// The unit waits to be saved before all others: an answer should be kept before it is acknowledged.
    pub fn answer(&mut self, id: &str, confirmed: bool) -> Option<&str> {
        let index = self.units.iter().position(|unit| unit.wish.as_deref() == Some(id))?;
        let before = self.messages.len();
        let unit = &mut self.units[index];
        unit.answer(confirmed, &mut self.messages);
        unit.is_dirty = true;
        self.dirty.retain(|other| *other != index);
        self.dirty.push_front(index);
        self.count(before);
        Some(&self.units[index].name)
    }

    fn index(&mut self, name: &str) -> Result<Option<usize>, PlanError> {
        if let Some(index) = self.names.get(name) {
            return Ok(Some(*index));
        }
        if self.plan.most_units <= self.units.len() {
            if self.refused.more().is_some() {
                let what = What::TooManyUnits { most: self.plan.most_units };
                self.tell(Event { unit: Some(name.to_owned()), time: None, what });
            }
            return Ok(None);
        }
        let index = self.units.len();
        self.units.push(Unit::new(&self.plan, name)?);
        self.names.insert(name.to_owned(), index);
        Ok(Some(index))
    }

    /// Adds an event of whoever reads the input.
    pub fn tell(&mut self, event: Event) {
        self.messages.push(Message::Event(event));
        self.count(self.messages.len() - 1);
    }

    fn count(&mut self, from: usize) {
        for message in &self.messages[from..] {
            match message {
                Message::Alarm(_) => self.counts.alarms += 1,
                Message::Event(_) => self.counts.events += 1,
                _ => {}
            }
        }
    }

    /// What is to be said, in order; each is handed out once.
    pub fn take_messages(&mut self) -> Vec<Message> {
        std::mem::take(&mut self.messages)
    }

    /// Whether there is something to be said.
    #[must_use]
    pub fn has_messages(&self) -> bool {
        !self.messages.is_empty()
    }

    /// The memory of the unit that has waited longest to be saved, with what it learned from when that is new.
    /// To be called after everything that was said so far is safe: what comes before a memory is never said
    /// again.
    pub fn next_to_save(&mut self) -> Option<(UnitMemory, Option<LearnedRows>)> {
        let unit = &mut self.units[self.dirty.pop_front()?];
        unit.is_dirty = false;
        let learned = unit.learned.take().map(LearnedRows::new);
        Some((UnitMemory::of(unit), learned))
    }

    /// A unit could not be saved, and waits again.
    pub fn not_saved(&mut self, memory: &UnitMemory, learned: Option<LearnedRows>) {
        let Some(&index) = self.names.get(memory.unit()) else { return };
        let unit = &mut self.units[index];
        unit.learned = learned.map(LearnedRows::into_rows).or(unit.learned.take());
        if !std::mem::replace(&mut unit.is_dirty, true) {
            self.dirty.push_back(index);
        }
    }

    /// Units that wait to be saved.
    #[must_use]
    pub fn to_save(&self) -> usize {
        self.dirty.len()
    }

    /// All units, in the order in which they came.
    #[must_use]
    pub fn units(&self) -> impl ExactSizeIterator<Item = UnitStatus<'_>> {
        self.units.iter().map(Unit::status)
    }

    /// One unit, if it has come.
    #[must_use]
    pub fn unit(&self, name: &str) -> Option<UnitStatus<'_>> {
        self.names.get(name).and_then(|index| self.units.get(*index)).map(Unit::status)
    }

    /// What went through so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }
}

impl std::fmt::Debug for Monitor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { units, counts, .. } = self;
        f.debug_struct("Monitor").field("units", &units.len()).field("counts", counts).finish()
    }
}
