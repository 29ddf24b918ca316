//! What a journal tells of the alarms of a plant, for whoever looks back.

use std::{collections::BTreeMap, fmt::Write as _};

use crate::message::{Alarm, Message, Reason, Why};

/// Alarms within ten minutes that one person can follow (ANSI/ISA-18.2-2016, table 5).
const FOLLOWED: usize = 10;
/// Those ten minutes.
const WINDOW_S: f64 = 600.0;
/// Causes and units that are listed; the rest are counted.
const LISTED: usize = 20;

/// One alarm from its beginning to its end.
#[derive(Clone, Debug, PartialEq)]
struct Story {
    unit: String,
    rule: String,
    raised: f64,
    since: f64,
    cleared: Option<(f64, Why)>,
    returns: u64,
    updates: u64,
    severity: u8,
    fault: Option<String>,
    size: Option<String>,
}

/// How often something was.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Counted {
    /// What.
    pub name: String,
    /// Alarms.
    pub alarms: u64,
    /// The unit of the first of them.
    pub first_out: String,
}

/// The alarms of a journal, in the order in which they were raised.
///
/// ```
/// use fd_watch::Audit;
///
/// let journal = concat!(
///     r#"{"type":"alarm","id":"p1/maximum/4","unit":"p1","rule":"maximum","time":4.0,"since":3.8,"severity":2,"#,
///     r#""why":"raised","fault":null,"size":null,"size_interval":null,"size_unit":null,"confidence":null,"#,
///     r#""statistic":8.0,"threshold":2.0,"residual":[]}"#, "\n",
///     r#"{"type":"cleared","id":"p1/maximum/4","unit":"p1","time":90.0,"why":"normal"}"#, "\n",
/// );
/// let audit = Audit::read(journal.as_bytes())?;
/// assert_eq!((audit.alarms(), audit.standing()), (1, 0));
/// assert!(audit.to_string().contains("p1"));
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Audit {
    stories: Vec<Story>,
    places: BTreeMap<String, usize>,
    /// Lines of a journal that were no message.
    unreadable: u64,
    /// Messages about alarms that were raised before the journal begins.
    without_beginning: u64,
}

impl Audit {
    /// Reads a journal, of which the last line may be cut off.
    ///
    /// # Errors
    ///
    /// Returns an error when it cannot be read, or when there are lines and none of them is a message.
    pub fn read(journal: impl std::io::BufRead) -> std::io::Result<Self> {
        let (mut audit, mut messages) = (Self::default(), 0_u64);
        for line in journal.split(b'\n') {
            let line = line?;
            if line.iter().all(u8::is_ascii_whitespace) {
                continue;
            }
            match serde_json::from_slice(&line) {
                Ok(message) => {
                    audit.take(&message);
                    messages += 1;
                }
                Err(_) => audit.unreadable += 1,
            }
        }
        // One line may be what was left of a first message.
        if messages == 0 && 1 < audit.unreadable {
            let found = format!(
                "expected messages of a monitor (NDJSON), found {} other lines",
                audit.unreadable
            );
            return Err(std::io::Error::new(std::io::ErrorKind::InvalidData, found));
        }
        Ok(audit)
    }

    /// Adds a message, in the order in which they were told.
    pub fn take(&mut self, message: &Message) {
        match message {
            Message::Alarm(alarm) => {
                // A message that was told twice is one.
                if !self.places.contains_key(&alarm.id) {
                    self.places.insert(alarm.id.clone(), self.stories.len());
                    self.stories.push(Story::of(alarm));
                }
            }
            Message::Update(alarm) => match self.story(&alarm.id) {
                Some(story) => story.goes_on(alarm),
                None => self.without_beginning += 1,
            },
            Message::Cleared(cleared) => match self.story(&cleared.id) {
                Some(story) => story.cleared = Some((cleared.time, cleared.why)),
                None => self.without_beginning += 1,
            },
            Message::Event(_) => {}
        }
    }

    fn story(&mut self, id: &str) -> Option<&mut Story> {
        self.places.get(id).and_then(|at| self.stories.get_mut(*at))
    }

    /// How many alarms there were.
    #[must_use]
    pub fn alarms(&self) -> usize {
        self.stories.len()
    }

    /// How many of them stand at the end.
    #[must_use]
    pub fn standing(&self) -> usize {
        self.stories.iter().filter(|story| story.cleared.is_none()).count()
    }

    /// The most alarms that were raised within ten minutes; more than ten are a flood.
    #[must_use]
    pub fn most_in_ten_minutes(&self) -> usize {
        let mut times: Vec<f64> = self.stories.iter().map(|story| story.raised).collect();
        times.sort_unstable_by(f64::total_cmp);
        let mut from = 0;
        let mut most = 0;
        for (to, time) in times.iter().enumerate() {
            while WINDOW_S < time - times[from] {
                from += 1;
            }
            most = most.max(to - from + 1);
        }
        most
    }

    /// Causes, the most frequent first: the last fault that was named, or the rule.
    #[must_use]
    pub fn causes(&self) -> Vec<Counted> {
        self.counted(|story| story.cause())
    }

    /// Units, those with the most alarms first.
    #[must_use]
    pub fn units(&self) -> Vec<Counted> {
        self.counted(|story| &story.unit)
    }

    fn counted<'a>(&'a self, name: impl Fn(&'a Story) -> &'a str) -> Vec<Counted> {
        let mut all: BTreeMap<&str, (u64, &Story)> = BTreeMap::new();
        for story in &self.stories {
            let (count, first) = all.entry(name(story)).or_insert((0, story));
            *count += 1;
            if story.since < first.since {
                *first = story;
            }
        }
        let counted = |(name, (alarms, first)): (&str, (u64, &Story))| Counted {
            name: name.to_owned(),
            alarms,
            first_out: first.unit.clone(),
        };
        let mut counted: Vec<Counted> = all.into_iter().map(counted).collect();
        counted.sort_by_key(|counted| std::cmp::Reverse(counted.alarms));
        counted
    }
}

impl Story {
    fn of(alarm: &Alarm) -> Self {
        Self {
            unit: alarm.unit.clone(),
            rule: alarm.rule.clone(),
            raised: alarm.time,
            since: alarm.since,
            cleared: None,
            returns: 0,
            updates: 0,
            severity: alarm.severity,
            fault: alarm.fault.clone(),
            size: size(alarm),
        }
    }

    /// The last fault that was named, or else the rule.
    fn cause(&self) -> &str {
        self.fault.as_deref().unwrap_or(&self.rule)
    }

    fn goes_on(&mut self, alarm: &Alarm) {
        self.updates += 1;
        self.severity = self.severity.max(alarm.severity);
        if alarm.why == Reason::Returned {
            (self.cleared, self.returns) = (None, self.returns + 1);
        }
        if alarm.fault.is_some() {
            (self.fault, self.size) = (alarm.fault.clone(), size(alarm));
        }
    }
}

fn size(alarm: &Alarm) -> Option<String> {
    let (size, unit) = (alarm.size?, alarm.size_unit.as_deref().unwrap_or("1"));
    Some(format!("{size:.3} {unit}"))
}

impl std::fmt::Display for Audit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut text = String::new();
        // Writing to a text does not fail.
        let _ = writeln!(
            text,
            "{} alarms, {} of them standing at the end; at most {} within ten minutes{}.",
            self.alarms(),
            self.standing(),
            self.most_in_ten_minutes(),
            if FOLLOWED < self.most_in_ten_minutes() { ", a flood" } else { "" },
        );
        for (what, count) in [
            ("lines that are no message", self.unreadable),
            (
                "messages about alarms that were raised before the journal begins",
                self.without_beginning,
            ),
        ] {
            if 0 < count {
                let _ = writeln!(text, "{count} {what}.");
            }
        }
        for (title, counted) in [("cause", self.causes()), ("unit", self.units())] {
            let _ = writeln!(text, "\n{title:32} {:>8}  first out", "alarms");
            for Counted { name, alarms, first_out } in counted.iter().take(LISTED) {
                let _ = writeln!(text, "{name:32} {alarms:>8}  {first_out}");
            }
            if LISTED < counted.len() {
                let _ = writeln!(text, "and {} more", counted.len() - LISTED);
            }
        }
        let _ = writeln!(
            text,
            "\n{:>14} {:>14} {:>14} {:8} {:>7} {:>7}  {:20} {:24} size",
            "since [s]",
            "raised [s]",
            "over [s]",
            "why",
            "updates",
            "returns",
            "unit",
            "fault (severity)"
        );
        for story in &self.stories {
            let (over, why) = match story.cleared {
                Some((time, Why::Normal)) => (format!("{time:.3}"), "normal"),
                Some((time, Why::Gap)) => (format!("{time:.3}"), "gap"),
                None => ("-".to_owned(), "stands"),
            };
            let fault = format!("{} ({})", story.cause(), story.severity);
            let _ = writeln!(
                text,
                "{:14.3} {:14.3} {over:>14} {why:8} {:>7} {:>7}  {:20} {:24} {}",
                story.since,
                story.raised,
                story.updates,
                story.returns,
                story.unit,
                fault,
                story.size.as_deref().unwrap_or("-"),
            );
        }
        f.write_str(&text)
    }
}
