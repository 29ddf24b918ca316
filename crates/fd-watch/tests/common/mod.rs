//! A plant with a wrong model, its logs, and monitors of it.
#![allow(
    clippy::unwrap_used,
    dead_code,
    unreachable_pub,
    reason = "shared by several test binaries"
)]

#[path = "../../../fdiag/tests/support/mod.rs"]
pub mod support;

use fd_log::LogMap;
use fd_model::{Record, file::LinearModel};
use fd_watch::{InputMap, Learning, Message, Monitor, Plan, Request, Row};

pub const MODEL: &str = r#"
version = 1
kind = "state-space"
sample_time = 0.1
inputs = [{ name = "fuel", unit = "kg/s", operating_point = 2.0, scale = 0.5 }]
outputs = [
    { name = "speed", unit = "rpm", operating_point = 3000.0, scale = 100.0 },
    { name = "temperature", unit = "K", operating_point = 900.0, scale = 50.0 },
]

[matrices]
A = [[0.90, 0.06], [-0.04, 0.83]]
B = [[0.06], [0.11]]
C = [[1.0, 0.0], [0.3, 1.0]]
"#;

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
    Request { spec: toml::from_str(SPEC).unwrap(), ..Request::new(model(), learning) }
}

/// Learned from a healthy log.
pub fn plan() -> Plan {
    request(Learning::Logs(vec![record(2000, 0)])).plan().unwrap()
}

/// A run in physical units.
pub fn record(samples: usize, variant: u32) -> Record {
    let run =
        support::run(&support::plant(), &support::input(samples, variant), 1e-3, variant.into());
    let model = model();
    let rows = run
        .samples()
        .map(|(u, y)| ([2.0 + 0.5 * u[0]], [3000.0 + 100.0 * y[0], 900.0 + 50.0 * y[1]]));
    Record::from_rows(model.input_channels(), model.output_channels(), rows, run.ts()).unwrap()
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
