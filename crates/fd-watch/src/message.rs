//! What a monitor says: alarms, what becomes of them, and events.

use fd_core::EventKind;
use serde::{Deserialize, Serialize};

/// One line of the output. `docs/watch.md` describes the JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Message {
    /// A fault was found.
    Alarm(Alarm),
    /// Something new is known of a fault that was found before.
    Update(Alarm),
    /// A fault is over, or can no longer be told.
    Cleared(Cleared),
    /// Anything else that somebody may want to know.
    Event(Event),
}

/// A fault, as it is known at one sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Alarm {
    /// Unit, rule and time of the sample that raised it: the same alarm has the same id, however often
    /// its samples are replayed.
    pub id: String,
    /// The unit.
    pub unit: String,
    /// Kind of the detector that found it.
    pub rule: String,
    /// Time in s of the sample at which this was said.
    pub time: f64,
    /// Time in s of the first sample that led to it.
    pub since: f64,
    /// Why this is said.
    #[serde(default)]
    pub why: Reason,
    /// How severe it is, from 1, by the largest ratio of statistic to threshold since it was raised.
    #[serde(default = "least_severe")]
    pub severity: u8,
    /// The fault that explains it best, when the spec asks for isolation and one is clear.
    pub fault: Option<String>,
    /// Its size, in `size_unit`.
    pub size: Option<f64>,
    /// Where the size lies, with the probability that the spec asks for.
    pub size_interval: Option<[f64; 2]>,
    /// Unit of the size.
    pub size_unit: Option<String>,
    /// Probability of this fault, or, without a name, that there is one at all.
    pub confidence: Option<f64>,
    /// Test statistic at this sample.
    pub statistic: f64,
    /// What it was compared with.
    pub threshold: f64,
    /// The compensated residual at this sample, in scaled units.
    pub residual: Vec<f64>,
}

/// Why an alarm is told, or told again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reason {
    /// It is new.
    #[default]
    Raised,
    /// Another fault explains it better.
    Cause,
    /// It is more severe than was told.
    Severity,
    /// It was over a while ago, and its fault is back.
    Returned,
    /// It still stands.
    Reminder,
}

fn least_severe() -> u8 {
    1
}

/// The end of an alarm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cleared {
    /// The alarm.
    pub id: String,
    /// Its unit.
    pub unit: String,
    /// Time in s of the sample at which it ended, after the off-delay.
    pub time: f64,
    /// Time in s of the last sample that spoke for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub last: Option<f64>,
    /// Why it ended.
    pub why: Why,
}

/// Why an alarm ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Why {
    /// The samples are normal again.
    Normal,
    /// Samples were missing for too long, so that the diagnosis began anew.
    Gap,
}

/// Something that happened to a unit or to the input.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Event {
    /// The unit; none for what cannot be ascribed to one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Time in s of the sample.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
    /// What happened.
    #[serde(flatten)]
    pub what: What,
}

/// What can happen besides alarms. Samples that are left out are never left out silently: the first of a
/// row of them is told at once, then the tenth, the hundredth and so on, and at its end how many there were.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[non_exhaustive]
pub enum What {
    /// A line is no sample.
    Unreadable {
        /// Number of the line, from 1.
        line: u64,
        /// Why.
        reason: String,
    },
    /// A column that nobody asked for; told once per column.
    UnknownColumn {
        /// Its name.
        column: String,
        /// The wanted column that may have been meant.
        nearest: Option<String>,
    },
    /// A sample lacks a column; its value is missing. Told for each row of such samples.
    MissingColumn {
        /// The column.
        column: String,
        /// Number of the line.
        line: u64,
    },
    /// A cell holds something else than a number; its value is missing.
    NotANumber {
        /// The column.
        column: String,
        /// Number of the line.
        line: u64,
        /// What is there.
        text: String,
    },
    /// A unit was refused because there are too many.
    TooManyUnits {
        /// Most units.
        most: usize,
    },
    /// Samples with the time of the one before: left out.
    Doubled {
        /// How many in a row so far.
        count: u64,
        /// Whether the row is over.
        ended: bool,
    },
    /// Samples that are a little older than the newest: left out.
    Late {
        /// How many in a row so far.
        count: u64,
        /// Whether the row is over.
        ended: bool,
        /// Time of the newest sample, in s.
        newest: f64,
    },
    /// Samples far older than the newest, as after a clock was set back: left out.
    ClockBackwards {
        /// How many in a row so far.
        count: u64,
        /// Whether the row is over.
        ended: bool,
        /// Time of the newest sample, in s.
        newest: f64,
    },
    /// A time far ahead which no other sample confirmed: left out.
    ClockJumped {
        /// The time, in s.
        to: f64,
    },
    /// Samples were missing for longer than is bridged; the diagnosis begins anew.
    Gap {
        /// Time of the last sample before, in s.
        from: f64,
        /// Time of the first sample after, in s.
        to: f64,
    },
    /// Samples were missing, and replaced by interpolation.
    Bridged {
        /// Time of the last sample before, in s.
        from: f64,
        /// Time of the first sample after, in s.
        to: f64,
        /// How many such holes in a row so far.
        count: u64,
        /// Whether the row is over.
        ended: bool,
    },
    /// Missing values were replaced by the last good ones.
    Held {
        /// How many samples in a row so far.
        count: u64,
        /// Whether the row is over.
        ended: bool,
    },
    /// Samples with missing values for longer than the spec holds them: left out.
    Refused {
        /// How many in a row so far.
        count: u64,
        /// Whether the row is over.
        ended: bool,
    },
    /// After a restart: samples that the snapshot had seen already were left out.
    Resumed {
        /// How many.
        seen: u64,
    },
    /// The unit began to learn what is normal from its own samples.
    LearningStarted {
        /// Samples that will be learned from.
        samples: u64,
    },
    /// What was learned so far was given up, because samples were missing for too long.
    LearningRestarted {
        /// Samples that were given up.
        samples: u64,
    },
    /// The unit has learned what is normal and is watched from now on.
    Learned {
        /// Samples that it learned from.
        samples: u64,
    },
    /// Nothing could be learned from these samples; learning begins anew.
    LearningFailed {
        /// Why.
        reason: String,
    },
    /// A unit would be trained again, and somebody has to say whether.
    RetrainingWanted {
        /// What the answer has to name: unit and time of the sample.
        id: String,
    },
    /// Nobody has answered, and there is no reason any more.
    RetrainingWithdrawn {
        /// The question.
        id: String,
    },
    /// Somebody has answered.
    RetrainingAnswered {
        /// The question.
        id: String,
        /// Whether the unit is trained again.
        confirmed: bool,
    },
    /// An answer came that answers no question, or that cannot be read.
    AnswerRefused {
        /// Why.
        reason: String,
    },
    /// The residual of a unit has grown for long, and its recent samples are being compared with the model.
    GapStudyStarted {
        /// How many.
        samples: u64,
    },
    /// Which effect the difference looks like.
    GapStudied {
        /// The answer in one sentence.
        answer: String,
    },
    /// No answer was found.
    GapStudyFailed {
        /// Why.
        reason: String,
    },
    /// Many units have failed of one cause within a short time: told when there are ten, a hundred and so on, and at the
    /// end. Their alarms are told as well.
    Flood {
        /// The fault or the rule that they have in common.
        cause: String,
        /// The unit that failed first.
        first_out: String,
        /// When it failed, in s.
        since: f64,
        /// Units so far.
        units: u64,
        /// Whether no more have followed for a while.
        ended: bool,
    },
    /// A broker was reached.
    Connected {
        /// Its address.
        broker: String,
        /// Whether it remembers this monitor. If it did not although the monitor was there before, samples that came
        /// meanwhile are lost.
        session: bool,
    },
    /// A broker cannot be reached, or the connection broke; it is tried again and again.
    Disconnected {
        /// Its address.
        broker: String,
        /// Why.
        reason: String,
    },
    /// Something within the diagnosis.
    Diagnosis {
        /// What.
        what: EventKind,
    },
}

impl Alarm {
    /// What alarms of other units may have in common with it: the fault, or else the rule.
    #[must_use]
    pub fn cause(&self) -> &str {
        self.fault.as_deref().unwrap_or(&self.rule)
    }
}

impl Message {
    /// The unit that it is about.
    #[must_use]
    pub fn unit(&self) -> Option<&str> {
        match self {
            Self::Alarm(alarm) | Self::Update(alarm) => Some(&alarm.unit),
            Self::Cleared(cleared) => Some(&cleared.unit),
            Self::Event(event) => event.unit.as_deref(),
        }
    }

    /// Time in s of the sample that caused it.
    #[must_use]
    pub fn time(&self) -> Option<f64> {
        match self {
            Self::Alarm(alarm) | Self::Update(alarm) => Some(alarm.time),
            Self::Cleared(cleared) => Some(cleared.time),
            Self::Event(event) => event.time,
        }
    }

    /// What makes it the same message when its samples are replayed; none for events, which are not promised.
    #[must_use]
    pub fn key(&self) -> Option<String> {
        match self {
            Self::Alarm(alarm) => Some(format!("{} raised", alarm.id)),
            Self::Update(alarm) => Some(format!("{} at {}", alarm.id, alarm.time)),
            Self::Cleared(cleared) => Some(format!("{} cleared at {}", cleared.id, cleared.time)),
            Self::Event(_) => None,
        }
    }

    /// As one line of JSON.
    ///
    /// ```
    /// use fd_watch::{Event, Message, What};
    ///
    /// let event = Event { unit: Some("p1".into()), time: Some(2.5), what: What::Resumed { seen: 3 } };
    /// let line = r#"{"type":"event","unit":"p1","time":2.5,"kind":"resumed","seen":3}"#;
    /// assert_eq!(Message::Event(event).to_json(), line);
    /// ```
    #[must_use]
    pub fn to_json(&self) -> String {
        // Names, numbers and lists only: there is nothing that JSON cannot say.
        serde_json::to_string(self).unwrap_or_default()
    }
}
