//! Logs as files; the formats are described in `docs/formats.md`.
//!
//! | What | Read | Write |
//! |------|------|-------|
//! | record | [`read_log`] with a [`LogMap`] | [`write_log`] |
//! | huge log, row by row | [`LogReader`] | |

mod columns;
mod error;
mod head;
mod header;
mod map;
mod reader;
mod writer;

pub use self::{
    error::LogError,
    map::{ColumnMap, LogMap, RowRule, TimeMap},
    reader::{Log, LogReader, LogRow, read_log, read_log_from},
    writer::{write_log, write_log_to},
};

#[cfg(test)]
mod tests;
