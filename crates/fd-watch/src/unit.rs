//! One unit: its clock, its diagnosis, its standing alarm.

use fd_core::{
    DynPipeline, EventKind, FrameError, Step,
    stage::{Decision, Phase as Compensation, Stage},
};

use crate::{
    alarms::{Annunciator, Heard, Said},
    clock::{Clock, Tick},
    input::Runs,
    message::{Alarm, Cleared, Event, Message, Reason, What, Why},
    plan::{Plan, PlanError},
};

/// What a unit is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Doing {
    /// It learns what is normal from its own samples.
    Learning {
        /// Samples that it has.
        samples: u64,
    },
    /// Its diagnosis settles: after its start, after a gap, or while the bias is learned again.
    Settling,
    /// Its samples are judged.
    Watched,
    /// It has a standing alarm.
    Alarmed,
}

pub(crate) enum Phase {
    Learning { rows: Vec<f64> },
    Watching(Box<DynPipeline>),
}

/// What a unit shows of itself after its latest sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Latest {
    /// Time in s.
    pub time: f64,
    /// Test statistic.
    pub statistic: f64,
    /// What it is compared with.
    pub threshold: f64,
}

/// How a unit is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitStatus<'a> {
    /// Its name.
    pub name: &'a str,
    /// What it does.
    pub doing: Doing,
    /// Its latest judged sample.
    pub latest: Latest,
    /// The question whether to train it again that waits for an answer.
    pub wish: Option<&'a str>,
}

pub(crate) struct Unit {
    pub name: String,
    pub clock: Clock,
    pub phase: Phase,
    pub alarm: Annunciator,
    /// The question whether to train again, until it is answered.
    pub wish: Option<String>,
    /// Time of the last sample on the grid.
    pub time: Option<f64>,
    pub refused: Runs,
    held: Runs,
    settled: bool,
    pub latest: Latest,
    /// What it learned from, until that is saved.
    pub learned: Option<Vec<f64>>,
    /// Whether the diagnosis is the unit's own.
    pub is_own: bool,
    /// Whether something happened since it was saved.
    pub is_dirty: bool,
    channels: usize,
    scaled: Vec<f64>,
}

impl Unit {
    pub(crate) fn new(plan: &Plan, name: &str) -> Result<Self, PlanError> {
        let phase = match plan.common()? {
            Some(pipeline) => Phase::Watching(Box::new(pipeline)),
            None => Phase::Learning { rows: Vec::new() },
        };
        Ok(Self {
            name: name.to_owned(),
            clock: Clock::default(),
            is_own: matches!(phase, Phase::Learning { .. }),
            phase,
            alarm: Annunciator::default(),
            wish: None,
            time: None,
            refused: Runs::default(),
            held: Runs::default(),
            settled: false,
            latest: Latest::default(),
            learned: None,
            is_dirty: false,
            channels: plan.channels().max(1),
            scaled: Vec::new(),
        })
    }

    pub(crate) fn doing(&self) -> Doing {
        match &self.phase {
            _ if self.alarm.standing().is_some() => Doing::Alarmed,
            Phase::Learning { rows } => {
                Doing::Learning { samples: (rows.len() / self.channels) as u64 }
            }
            Phase::Watching(_) if self.settled => Doing::Watched,
            Phase::Watching(_) => Doing::Settling,
        }
    }

    pub(crate) fn status(&self) -> UnitStatus<'_> {
        UnitStatus {
            name: &self.name,
            doing: self.doing(),
            latest: self.latest,
            wish: self.wish.as_deref(),
        }
    }

    /// Takes a sample as it arrived.
    pub(crate) fn take(
        &mut self,
        plan: &Plan,
        time: f64,
        values: &[f64],
        messages: &mut Vec<Message>,
    ) {
        self.is_dirty = true;
        // The clock is apart from the rest while it tells the rest what to do.
        let mut clock = std::mem::take(&mut self.clock);
        clock.take(&plan.clock, time, values, &mut |tick| match tick {
            Tick::Sample { time, values } => self.sample(plan, time, values, messages),
            Tick::Anew => self.anew(messages),
            Tick::Told(time, what) => self.tell(time, what, messages),
        });
        self.clock = clock;
    }

    fn tell(&self, time: f64, what: What, messages: &mut Vec<Message>) {
        let unit = Some(self.name.clone());
        messages.push(Message::Event(Event { unit, time: Some(time), what }));
    }

    /// The next sample does not follow the last one.
    fn anew(&mut self, messages: &mut Vec<Message>) {
        let time = self.time.unwrap_or(0.0);
        match &mut self.phase {
            Phase::Learning { rows } => {
                let samples = (rows.len() / self.channels) as u64;
                rows.clear();
                if 0 < samples {
                    self.tell(time, What::LearningRestarted { samples }, messages);
                }
            }
            Phase::Watching(pipeline) => pipeline.reset(),
        }
        // The diagnosis begins as it began: what it asked is settled.
        if let Some(id) = self.wish.take() {
            self.tell(time, What::RetrainingWithdrawn { id }, messages);
        }
        self.settled = false;
        self.refused = Runs::default();
        self.held = Runs::default();
        if self.alarm.standing().is_some() {
            self.alarm.clear(time);
            messages.push(self.cleared(time, Why::Gap));
        }
    }

    fn cleared(&self, time: f64, why: Why) -> Message {
        let id = self.alarm.id.clone().unwrap_or_default();
        Message::Cleared(Cleared {
            id,
            unit: self.name.clone(),
            time,
            last: Some(self.alarm.last),
            why,
        })
    }

    /// Takes a sample on the grid.
    fn sample(&mut self, plan: &Plan, time: f64, values: &[f64], messages: &mut Vec<Message>) {
        let mut scaled = std::mem::take(&mut self.scaled);
        plan.scale(values, &mut scaled);
        match &mut self.phase {
            Phase::Learning { rows } => {
                let is_first = rows.is_empty();
                rows.extend_from_slice(&scaled);
                let samples = (rows.len() / self.channels) as u64;
                if is_first {
                    let what = What::LearningStarted { samples: plan.to_learn };
                    self.tell(time, what, messages);
                }
                if plan.to_learn <= samples {
                    self.learn(plan, time, messages);
                }
            }
            Phase::Watching(_) => self.watch(plan, time, &scaled, messages),
        }
        self.scaled = scaled;
        self.time = Some(time);
    }

    fn learn(&mut self, plan: &Plan, time: f64, messages: &mut Vec<Message>) {
        let Phase::Learning { rows } = &mut self.phase else { return };
        let rows = std::mem::take(rows);
        let learned = plan.own(&rows).map(|mut pipeline| {
            warm_up(plan, &mut pipeline, &rows);
            pipeline
        });
        match learned {
            Ok(pipeline) => {
                self.phase = Phase::Watching(Box::new(pipeline));
                self.learned = Some(rows);
                self.tell(time, What::Learned { samples: plan.to_learn }, messages);
            }
            Err(error) => {
                self.tell(time, What::LearningFailed { reason: error.to_string() }, messages);
            }
        }
    }

    fn watch(&mut self, plan: &Plan, time: f64, scaled: &[f64], messages: &mut Vec<Message>) {
        let is_complete = scaled.iter().all(|v| v.is_finite());
        if is_complete && 0 < self.refused.count {
            let is_long = plan.clock.longest_gap < self.refused.count as f64 * plan.clock.step;
            if let Some(count) = self.refused.end() {
                self.tell(time, What::Refused { count, ended: true }, messages);
            }
            if is_long {
                self.anew(messages);
            }
        }
        let Phase::Watching(pipeline) = &mut self.phase else { return };
        let (u, y) = scaled.split_at(plan.clock.inputs.min(scaled.len()));
        match pipeline.step(u, y) {
            Ok(step) => {
                let Step { k, verdict, decision, events, phase, .. } = step;
                self.settled = phase == Compensation::Compensating;
                let (statistic, threshold) = (verdict.statistic, verdict.threshold);
                self.latest = Latest { time, statistic, threshold };
                let (is_fault, hypothesis) = match decision {
                    Decision::Fault(fault) => (true, fault.hypothesis),
                    _ => (false, None),
                };
                let ratio = if threshold > 0.0 { statistic / threshold } else { f64::INFINITY };
                let is_shelved = plan.alarms.is_shelved(&self.name, time);
                let heard = Heard { time, is_fault, hypothesis, ratio, is_shelved };
                let name = || format!("{}/{}/{time}", self.name, plan.rule);
                let said = self.alarm.hear(&plan.alarms, heard, name);
                // What is not told does not need the residual.
                let residual = if said.is_some() { step.compensated.to_vec() } else { Vec::new() };
                for what in events.iter() {
                    match what {
                        EventKind::SampleHeld => {
                            if let Some(count) = self.held.more() {
                                let what = What::Held { count, ended: false };
                                self.tell(time, what, messages);
                            }
                        }
                        EventKind::RetrainingWanted => {
                            let id = format!("{}/retraining/{time}", self.name);
                            self.wish = Some(id.clone());
                            self.tell(time, What::RetrainingWanted { id }, messages);
                        }
                        // Of what was answered there is nothing to take back.
                        EventKind::RetrainingWithdrawn => {
                            if let Some(id) = self.wish.take() {
                                self.tell(time, What::RetrainingWithdrawn { id }, messages);
                            }
                        }
                        // An alarm says more than this.
                        EventKind::AlarmRaised | EventKind::AlarmCleared => {}
                        what => self.tell(time, What::Diagnosis { what }, messages),
                    }
                }
                if is_complete && let Some(count) = self.held.end() {
                    self.tell(time, What::Held { count, ended: true }, messages);
                }
                match (said, decision) {
                    (None, _) => {}
                    (Some(Said::Cleared), _) => messages.push(self.cleared(time, Why::Normal)),
                    (Some(said), decision) => {
                        let alarm = self.told(plan, said, (time, k), decision, residual);
                        let is_new = said == Said::Raised;
                        messages.push(if is_new {
                            Message::Alarm(alarm)
                        } else {
                            Message::Update(alarm)
                        });
                    }
                }
            }
            Err(FrameError::NonFinite { .. }) => {
                if let Some(count) = self.refused.more() {
                    self.tell(time, What::Refused { count, ended: false }, messages);
                }
            }
            // The rows have the channels of the model, as the pipeline has.
            Err(FrameError::Length { .. } | _) => {}
        }
    }

    /// Trains again or not, as somebody has answered.
    pub(crate) fn answer(&mut self, confirmed: bool, messages: &mut Vec<Message>) {
        let Some(id) = self.wish.take() else { return };
        if confirmed && let Phase::Watching(pipeline) = &mut self.phase {
            pipeline.retrain();
            self.settled = false;
        }
        let what = What::RetrainingAnswered { id, confirmed };
        self.tell(self.time.unwrap_or(0.0), what, messages);
    }

    fn told(
        &self,
        plan: &Plan,
        said: Said,
        (time, k): (f64, u64),
        decision: Decision<f64>,
        residual: Vec<f64>,
    ) -> Alarm {
        // A reminder may come while the diagnosis sees no fault and the off-delay has not passed.
        let fault = if let Decision::Fault(fault) = decision { Some(fault) } else { None };
        let place = self.alarm.hypothesis.and_then(|at| plan.places.get(at));
        let scale = place.map_or(1.0, |place| place.scale);
        let since = fault.map_or(k, |fault| fault.since);
        Alarm {
            id: self.alarm.id.clone().unwrap_or_default(),
            unit: self.name.clone(),
            rule: plan.rule.clone(),
            time,
            since: time - k.saturating_sub(since) as f64 * plan.clock.step,
            why: match said {
                Said::Raised | Said::Cleared => Reason::Raised,
                Said::Cause => Reason::Cause,
                Said::Severity => Reason::Severity,
                Said::Returned => Reason::Returned,
                Said::Reminder => Reason::Reminder,
            },
            severity: self.alarm.severity,
            fault: place.map(|place| place.name.clone()),
            size: fault.and_then(|fault| fault.size).map(|size| scale * size),
            size_interval: fault
                .and_then(|fault| fault.size_interval)
                .map(|ends| ends.map(|end| scale * end)),
            size_unit: place.map(|place| place.unit.clone()),
            confidence: fault.and_then(|fault| fault.confidence),
            statistic: self.latest.statistic,
            threshold: self.latest.threshold,
            residual,
        }
    }
}

/// Lets a fresh diagnosis see what it learned from, so that it has settled when the next sample comes.
fn warm_up(plan: &Plan, pipeline: &mut DynPipeline, rows: &[f64]) {
    let channels = plan.channels().max(1);
    for row in rows.chunks_exact(channels) {
        let (u, y) = row.split_at(plan.clock.inputs.min(channels));
        // A sample with missing values is left out, as it was in learning.
        let _ = pipeline.step(u, y);
    }
}
