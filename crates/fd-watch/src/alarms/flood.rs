//! Many units that fail of the same cause: told as one thing.

use std::collections::{BTreeMap, HashSet, VecDeque};

use super::settings::AlarmSettings;
use crate::message::{Alarm, Event, What};

/// The alarms of one cause that were raised lately.
#[derive(Debug, Default)]
struct Cause {
    /// Time and unit, in the order in which they came.
    recent: VecDeque<(f64, String)>,
    flood: Option<Flood>,
}

#[derive(Debug)]
struct Flood {
    /// The unit that failed first, and when.
    first_out: String,
    since: f64,
    units: HashSet<String>,
    told: u64,
}

/// Counts alarms by cause. Not kept over a restart: a flood that goes on is told anew.
#[derive(Debug, Default)]
pub(crate) struct Floods(BTreeMap<String, Cause>);

impl Floods {
    /// An alarm was raised; what is to be told of its flood, if it is part of one.
    pub(crate) fn raised(&mut self, settings: &AlarmSettings, alarm: &Alarm) -> Option<Event> {
        let (cause, unit, time) = (alarm.cause(), &alarm.unit, alarm.time);
        let of = self.0.entry(cause.to_owned()).or_default();
        of.forget(settings, time);
        of.recent.push_back((time, unit.clone()));
        if of.recent.len() < settings.flood_alarms {
            return None;
        }
        let flood = of.flood.get_or_insert_with(|| {
            // Clocks of units differ: the first is the one that failed first, not the one that was heard first.
            let first = of.recent.iter().min_by(|a, b| a.0.total_cmp(&b.0));
            let (since, first_out) = first.cloned().unwrap_or((time, unit.clone()));
            let units = of.recent.iter().map(|(_, unit)| unit.clone()).collect();
            Flood { first_out, since, units, told: 0 }
        });
        flood.units.insert(unit.clone());
        if time < flood.since {
            (flood.since, flood.first_out) = (time, unit.clone());
        }
        let count = flood.units.len() as u64;
        // The first time, then each time that it has grown tenfold.
        let is_due = flood.told == 0 || 10 * flood.told <= count;
        is_due.then(|| {
            flood.told = count;
            flood.event(cause, time, false)
        })
    }

    /// Time goes on: floods that are over are told.
    pub(crate) fn pass(&mut self, settings: &AlarmSettings, time: f64) -> Vec<Event> {
        let mut over = Vec::new();
        for (cause, of) in &mut self.0 {
            of.forget(settings, time);
            if of.recent.is_empty()
                && let Some(flood) = of.flood.take()
            {
                over.push(flood.event(cause, time, true));
            }
        }
        self.0.retain(|_, of| !of.recent.is_empty());
        over
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl Cause {
    fn forget(&mut self, settings: &AlarmSettings, time: f64) {
        while self.recent.front().is_some_and(|(then, _)| settings.flood_s < time - then) {
            self.recent.pop_front();
        }
    }
}

impl Flood {
    fn event(&self, cause: &str, time: f64, ended: bool) -> Event {
        let what = What::Flood {
            cause: cause.to_owned(),
            first_out: self.first_out.clone(),
            since: self.since,
            units: self.units.len() as u64,
            ended,
        };
        Event { unit: None, time: Some(time), what }
    }
}
