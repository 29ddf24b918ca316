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

mod bits;
mod board;
mod clock;
#[cfg(feature = "http")]
mod http;
mod input;
mod memory;
mod message;
mod monitor;
mod plan;
mod state;
mod unit;

#[cfg(feature = "http")]
pub use self::http::serve;
pub use self::{
    board::{Answer, Board, Health},
    input::{ColumnsError, Format, InputMap, Row, RowReader},
    memory::{LearnedRows, MemoryError, UnitMemory},
    message::{Alarm, Cleared, Event, Message, What, Why},
    monitor::{Counts, Monitor, UnitStatus},
    plan::{Learning, Plan, PlanError, Request},
    state::{Identity, Outbox, StateError, StateFolder},
    unit::{Doing, Latest},
};
