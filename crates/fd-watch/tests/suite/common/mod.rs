//! A plant with a wrong model, its logs, and monitors of it.
#![allow(clippy::unwrap_used, dead_code, unreachable_pub, reason = "shared by several tests")]

use crate::support::physical::{self, MODEL};
use fd_log::LogMap;
use fd_model::{Record, file::LinearModel};
use fd_watch::{AlarmSettings, InputMap, Learning, Message, Monitor, Plan, Request, Row};

pub const SPEC: &str = r#"
hold_missing = 3
bias.orders = { kind = "fixed", na = 2, nb = 3 }
detector = { kind = "maximum", margin = 0.5 }
rule = { raise = 3, out_of = 3, clear = 5 }
isolation = { kind = "nearest", faults = "sensors" }
"#;

pub fn model() -> LinearModel {
    LinearModel::parse("model.toml", MODEL).unwrap()
}

pub fn request(learning: Learning) -> Request {
    // As logs are judged: nothing is delayed or held.
    let alarms = AlarmSettings::immediate();
    Request { spec: toml::from_str(SPEC).unwrap(), alarms, ..Request::new(model(), learning) }
}

/// Learned from a healthy log.
pub fn plan() -> Plan {
    request(Learning::Logs(vec![record(2000, 0)])).plan().unwrap()
}

/// A run in physical units.
pub fn record(samples: usize, variant: u32) -> Record {
    physical::log(&crate::support::input(samples, variant), variant.into())
}

/// Two faults of the temperature sensor, each for 10 s.
pub fn faulty(variant: u32) -> Record {
    let mut record = record(1200, variant);
    for k in (400..500).chain(800..900) {
        record.y_mut(k)[1] += 5.0;
    }
    record
}

/// Rows with the times they would have.
pub fn rows(record: &Record) -> Vec<(f64, Vec<f64>)> {
    let values = |(u, y): (&[f64], &[f64])| [u, y].concat();
    record.samples().enumerate().map(|(k, s)| (k as f64 * 0.1, values(s))).collect()
}

pub fn input() -> InputMap {
    InputMap::new(LogMap::for_model(&model()))
}

pub fn take(monitor: &mut Monitor, unit: &str, rows: &[(f64, Vec<f64>)]) -> Vec<Message> {
    for (time, values) in rows {
        monitor.take(Row { unit, time: *time, values }).unwrap();
    }
    monitor.take_messages()
}

/// What is promised: alarms and what becomes of them.
pub fn promised(messages: &[Message]) -> Vec<&Message> {
    messages.iter().filter(|message| message.key().is_some()).collect()
}

/// Numbers between 0 and 1, the same at every run.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f64 {
        // Marsaglia's xorshift.
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}
