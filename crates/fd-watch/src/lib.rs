//! `fdiag watch` as a library: the on-line monitor.
//!
//! ```text
//! line ──RowReader──▶ row ──Clock──▶ samples on an even time base ──Pipeline──▶ messages
//!                      │                                                          │
//!                      └── one Unit per key: clock, diagnosis, standing alarm     ├─▶ journal, synced
//!                                                                                 ├─▶ published
//!                                                                                 └─▶ memory of the unit, saved
//! ```
//!
//! [`RowReader`] turns lines into rows, [`Monitor`] turns rows into messages, and [`StateFolder`] keeps what
//! must survive. None of them has a thread or a clock; `fdiag_cli::watch` runs them next to a plant. Every
//! defect of a stream is a typed [`Event`]; no sample is dropped silently, and none is judged at a time other
//! than its own.
//!
//! Two lines of a stream, of which the second comes twice:
//!
//! ```
//! # use fd_model::file::LinearModel;
//! use fd_log::LogMap;
//! use fd_watch::{Format, InputMap, Learning, Message, Monitor, Request, RowReader, What};
//!
//! # let text = r#"
//! # version = 1
//! # kind = "state-space"
//! # sample_time = 1.0
//! # inputs = [{ name = "u" }]
//! # outputs = [{ name = "y" }]
//! # matrices = { A = [[0.9]], B = [[0.1]], C = [[1.0]], D = [[0.0]] }
//! # "#;
//! let model = LinearModel::parse("model.toml", text)?;
//! let mut rows = RowReader::new(Format::Ndjson, InputMap::new(LogMap::for_model(&model)));
//! let mut monitor = Monitor::new(Request::new(model, Learning::Stream { samples: 600 }).plan()?);
//! let first = r#"{"t": 0, "u": 0.5, "y": 0.1}"#;
//! let second = r#"{"t": 1, "u": 0.5, "y": 0.2}"#;
//! for line in [first, second, second] {
//!     if rows.read(line.as_bytes())? {
//!         monitor.take(rows.row())?;
//!     }
//! }
//! let doubled = |message: &Message| {
//!     matches!(message, Message::Event(event) if matches!(event.what, What::Doubled { .. }))
//! };
//! assert_eq!(monitor.take_messages().iter().filter(|message| doubled(message)).count(), 1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod alarms;
mod bits;
mod board;
mod clock;
#[cfg(feature = "http")]
mod http;
mod input;
mod learning;
mod memory;
mod message;
mod monitor;
mod plan;
mod state;
mod unit;

#[cfg(feature = "http")]
pub use self::http::{Access, serve};
pub use self::{
    alarms::{AlarmSettings, Audit, Counted, SettingsError, Shelf},
    board::{Answer, Board, Health},
    input::{ColumnsError, Format, InputMap, Row, RowReader},
    learning::Learning,
    memory::{LearnedRows, MemoryError, UnitMemory},
    message::{Alarm, Cleared, Event, Message, Reason, What, Why},
    monitor::{Counts, Monitor},
    plan::{Plan, PlanError, Request},
    state::{Identity, Outbox, StateError, StateFolder},
    unit::{Doing, Latest, UnitStatus},
};
