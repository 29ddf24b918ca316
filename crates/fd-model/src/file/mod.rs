//! Model files (TOML) and logs (CSV); both formats are described in `docs/formats.md`.
//!
//! | What | Read | Write |
//! |------|------|-------|
//! | linear model | [`LinearModel::read`] | [`LinearModel::write`] |
//! | record | [`read_log`] with a [`LogMap`] | [`write_log`] |
//! | huge log, row by row | [`LogReader`] | |

mod atomic;
mod log_columns;
mod log_error;
mod log_head;
mod log_header;
mod log_map;
mod log_reader;
mod log_writer;
mod model;
mod model_error;
mod model_parse;
mod model_write;

pub use self::{
    atomic::write_atomically,
    log_error::LogError,
    log_map::{ColumnMap, LogMap, RowRule, TimeMap},
    log_reader::{Log, LogReader, LogRow, read_log, read_log_from},
    log_writer::{write_log, write_log_to},
    model::{LinearModel, LinearSystem, ModelChannel},
    model_error::{FileAction, ModelFileError},
};

#[cfg(test)]
mod tests;
