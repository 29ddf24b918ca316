//! What a monitor shows of itself and its units to whoever looks.

use std::{
    collections::{HashMap, HashSet, VecDeque},
    fmt::Write,
    sync::{Condvar, Mutex, MutexGuard, PoisonError, mpsc::SyncSender},
    time::Duration,
};

use serde::Serialize;

use crate::{
    message::{Event, Message, What},
    monitor::Monitor,
    unit::Doing,
};

/// Messages that a page is shown when it is opened.
const MESSAGES: usize = 100;
/// Units of which a page has a picture.
const PICTURED: usize = 24;
/// Points of a picture.
const POINTS: usize = 240;

/// How the monitor itself is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Health {
    /// Samples taken.
    pub samples: u64,
    /// Samples of units that were refused.
    pub refused: u64,
    /// Samples dropped for their time: doubled, late, of a clock that went back or jumped.
    pub dropped: u64,
    /// Lines that were read.
    pub lines: u64,
    /// Alarms raised since the start.
    pub alarms: u64,
    /// Events told since the start.
    pub events: u64,
    /// Units by what they do: learning, settling, watched, alarmed.
    pub units: [u64; 4],
    /// Bytes of the journal that a broker has not confirmed, where there is one.
    pub unheard: Option<u64>,
    /// Units that wait to be saved.
    pub unsaved: u64,
    /// Whether the last saving failed.
    pub cannot_save: bool,
    /// Time in s that the newest lines waited before they were judged.
    pub lag_s: f64,
    /// Time in s since the last sample came.
    pub age_s: Option<f64>,
    /// Time in s since the start.
    pub up_s: f64,
    /// Resident memory in bytes, where the system says.
    pub memory: Option<u64>,
}

/// A unit on a page.
#[derive(Clone, Debug, Default, Serialize)]
struct Card {
    unit: String,
    doing: &'static str,
    learned: u64,
    time: f64,
    statistic: f64,
    threshold: f64,
    wish: Option<String>,
}

/// Whether to train a unit again, as somebody has said it on the page.
#[derive(Debug)]
pub struct Answer {
    /// The question.
    pub id: String,
    /// Whether to train again.
    pub confirmed: bool,
    /// Takes what became of it: an error in words, for whoever has answered.
    pub heard: SyncSender<Result<(), String>>,
}

#[derive(Default)]
struct Inner {
    answers: Vec<Answer>,
    health: Health,
    cards: Vec<Card>,
    /// Of pictured units: time, statistic, threshold.
    history: HashMap<String, VecDeque<[f64; 3]>>,
    messages: VecDeque<(u64, String)>,
    /// Causes of floods, and alarms that are part of one: told as one thing.
    floods: HashSet<String>,
    drowned: HashSet<String>,
    last: u64,
    /// Counts the looks; a page waits for the next.
    look: u64,
}

/// Shared between a monitor and those who look at it. Nobody who looks can keep the monitor waiting for long: what is
/// under the lock is only copied.
///
/// ```
/// use fd_watch::{Board, Health};
///
/// let board = Board::default();
/// board.set_health(Health { samples: 3, ..Health::default() });
/// assert!(board.metrics().contains("fdiag_watch_samples_total 3"));
/// ```
#[derive(Default)]
pub struct Board {
    inner: Mutex<Inner>,
    changed: Condvar,
}

impl Inner {
    /// Whether a message is about an alarm of a flood that is shown already.
    fn is_drowned(&mut self, message: &Message) -> bool {
        match message {
            Message::Event(Event { what: What::Flood { cause, ended, .. }, .. }) => {
                if *ended {
                    self.floods.remove(cause);
                } else {
                    self.floods.insert(cause.clone());
                }
                false
            }
            Message::Alarm(alarm) => {
                let is_drowned = self.floods.contains(alarm.cause());
                if is_drowned {
                    self.drowned.insert(alarm.id.clone());
                }
                is_drowned
            }
            Message::Update(alarm) => self.drowned.contains(&alarm.id),
            Message::Cleared(cleared) => self.drowned.remove(&cleared.id),
            Message::Event(_) => false,
        }
    }
}

impl Board {
    fn lock(&self) -> MutexGuard<'_, Inner> {
        // Whoever panicked with the lock has left numbers, at worst old ones.
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Shows what was said; of the alarms of a flood only the flood, once it was told.
    pub fn say(&self, messages: &[Message]) {
        let mut inner = self.lock();
        for message in messages {
            if inner.is_drowned(message) {
                continue;
            }
            inner.last += 1;
            let entry = (inner.last, message.to_json());
            inner.messages.push_back(entry);
        }
        let surplus = inner.messages.len().saturating_sub(MESSAGES);
        inner.messages.drain(..surplus);
        drop(inner);
        self.changed.notify_all();
    }

    /// Shows how the monitor is.
    pub fn set_health(&self, health: Health) {
        self.lock().health = health;
    }

    /// Shows how the units are: those with an alarm first, then as they came.
    pub fn look_at(&self, monitor: &Monitor) {
        let mut inner = self.lock();
        inner.look += 1;
        let mut cards: Vec<(bool, Card)> = Vec::new();
        for unit in monitor.units() {
            let is_alarmed = unit.doing == Doing::Alarmed || unit.wish.is_some();
            if !is_alarmed && PICTURED <= cards.len() {
                continue;
            }
            let learned = if let Doing::Learning { samples } = unit.doing { samples } else { 0 };
            let (doing, latest) = (word(unit.doing), unit.latest);
            let card = Card {
                unit: unit.name.to_owned(),
                doing,
                learned,
                time: latest.time,
                statistic: latest.statistic,
                threshold: latest.threshold,
                wish: unit.wish.map(str::to_owned),
            };
            cards.push((!is_alarmed, card));
        }
        cards.sort_by_key(|(is_well, _)| *is_well);
        cards.truncate(PICTURED);
        let cards: Vec<Card> = cards.into_iter().map(|(_, card)| card).collect();
        inner.history.retain(|unit, _| cards.iter().any(|card| card.unit == *unit));
        // What is not judged yet has no place in a picture of judgements.
        let is_judged = |card: &&Card| card.doing == "watched" || card.doing == "alarmed";
        for card in cards.iter().filter(is_judged) {
            let points = inner.history.entry(card.unit.clone()).or_default();
            if points.back().is_none_or(|last| last[0] < card.time) {
                points.push_back([card.time, card.statistic, card.threshold]);
            }
            let surplus = points.len().saturating_sub(POINTS);
            points.drain(..surplus);
        }
        inner.cards = cards;
        drop(inner);
        self.changed.notify_all();
    }

    /// Answers that were given since it was last asked.
    pub fn take_answers(&self) -> Vec<Answer> {
        std::mem::take(&mut self.lock().answers)
    }

    /// Hands an answer to whoever runs the monitor; false when too many wait.
    pub(crate) fn put_answer(&self, answer: Answer) -> bool {
        let mut inner = self.lock();
        let has_room = inner.answers.len() < MESSAGES;
        if has_room {
            inner.answers.push(answer);
        }
        has_room
    }

    /// In the text format of Prometheus.
    #[must_use]
    pub fn metrics(&self) -> String {
        let health = self.lock().health;
        let [learning, settling, watched, alarmed] = health.units;
        let mut text = String::new();
        let mut add = |name: &str, kind: &str, help: &str, values: &[(&str, f64)]| {
            // Writing to a text does not fail.
            let _ = writeln!(
                text,
                "# HELP fdiag_watch_{name} {help}\n# TYPE fdiag_watch_{name} {kind}"
            );
            for (labels, value) in values {
                let _ = writeln!(text, "fdiag_watch_{name}{labels} {value}");
            }
        };
        let count = |n: u64| n as f64;
        add("samples_total", "counter", "Samples taken.", &[("", count(health.samples))]);
        add("lines_total", "counter", "Lines read.", &[("", count(health.lines))]);
        let refused = count(health.refused);
        add("refused_total", "counter", "Samples of units beyond the limit.", &[("", refused)]);
        let dropped = "Samples doubled, late, or of a wrong clock.";
        add("dropped_total", "counter", dropped, &[("", count(health.dropped))]);
        add("alarms_total", "counter", "Alarms raised.", &[("", count(health.alarms))]);
        add("events_total", "counter", "Events told.", &[("", count(health.events))]);
        let units = [
            ("{doing=\"learning\"}", count(learning)),
            ("{doing=\"settling\"}", count(settling)),
            ("{doing=\"watched\"}", count(watched)),
            ("{doing=\"alarmed\"}", count(alarmed)),
        ];
        add("units", "gauge", "Units by what they do.", &units);
        add(
            "unsaved_units",
            "gauge",
            "Units that wait to be saved.",
            &[("", count(health.unsaved))],
        );
        if let Some(unheard) = health.unheard {
            let help = "Bytes of alarms that the broker has not confirmed.";
            add("unheard_bytes", "gauge", help, &[("", count(unheard))]);
        }
        let failing = f64::from(u8::from(health.cannot_save));
        add("saving_failed", "gauge", "1 while units cannot be saved.", &[("", failing)]);
        let lag = "Time that the newest lines waited before they were judged.";
        add("lag_seconds", "gauge", lag, &[("", health.lag_s)]);
        if let Some(age) = health.age_s {
            add("last_sample_age_seconds", "gauge", "Time since a sample came.", &[("", age)]);
        }
        add("up_seconds", "gauge", "Time since the start.", &[("", health.up_s)]);
        if let Some(memory) = health.memory {
            add("memory_bytes", "gauge", "Resident memory.", &[("", count(memory))]);
        }
        text
    }

    /// Whether all is well with the monitor, and how it is, as JSON.
    #[must_use]
    pub fn health(&self) -> (bool, String) {
        let health = self.lock().health;
        (!health.cannot_save, serde_json::to_string(&health).unwrap_or_default())
    }

    /// Everything that a page shows when it is opened, and the place from which on [`Board::wait`] goes on.
    pub(crate) fn page(&self) -> (String, Place) {
        let inner = self.lock();
        let Inner { health, cards, history, messages, .. } = &*inner;
        let messages: Vec<&str> = messages.iter().map(|(_, json)| json.as_str()).collect();
        let state = serde_json::json!({ "health": health, "cards": cards, "history": history });
        let text = format!("{{\"state\":{state},\"messages\":[{}]}}", messages.join(","));
        (text, Place { message: inner.last, look: inner.look })
    }

    /// Waits until there is something new, at most so long, and returns it: pairs of a kind and JSON.
    pub(crate) fn wait(&self, place: &mut Place, longest: Duration) -> Vec<(&'static str, String)> {
        let inner = self.lock();
        let old = *place;
        let is_old = |inner: &mut Inner| inner.last == old.message && inner.look == old.look;
        let waited = self.changed.wait_timeout_while(inner, longest, is_old);
        let (inner, _) = waited.unwrap_or_else(PoisonError::into_inner);
        let mut new: Vec<(&'static str, String)> = inner
            .messages
            .iter()
            .filter(|(number, _)| place.message < *number)
            .map(|(_, json)| ("message", json.clone()))
            .collect();
        if place.look < inner.look {
            let Inner { health, cards, .. } = &*inner;
            new.push(("look", serde_json::json!({ "health": health, "cards": cards }).to_string()));
        }
        *place = Place { message: inner.last, look: inner.look };
        new
    }
}

/// How far somebody has read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    message: u64,
    look: u64,
}

fn word(doing: Doing) -> &'static str {
    match doing {
        Doing::Learning { .. } => "learning",
        Doing::Settling => "settling",
        Doing::Watched => "watched",
        Doing::Alarmed => "alarmed",
    }
}

impl std::fmt::Debug for Board {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Board").field("health", &self.lock().health).finish_non_exhaustive()
    }
}
