//! The seam between formats and logs: a table whose rows come one after the other.

use std::io;

use fd_model::file::FileAction;
use thiserror::Error;

use crate::{error::LogError, header::HeaderColumn};

/// A log file as a table: named columns, and rows of numbers that are read one after the other.
///
/// A format is one type that implements this, and one line in the list of [formats](crate::FORMATS).
/// Everything else - which column is which channel, in which unit, which rows belong to the log, an even
/// time base - is the business of [`LogReader`](crate::LogReader), which works on any source. A source
/// converts nothing and selects nothing; it holds one row in memory, so that a log of any size can be read.
///
/// ```
/// use fd_log::{HeaderColumn, LogError, LogMap, LogReader, LogSource};
/// use fd_model::Channel;
///
/// /// A ramp that nobody has stored.
/// struct Ramp {
///     columns: Vec<HeaderColumn>,
///     row: u64,
/// }
///
/// impl LogSource for Ramp {
///     fn file(&self) -> &str {
///         "ramp"
///     }
///     fn columns(&self) -> &[HeaderColumn] {
///         &self.columns
///     }
///     fn next_row(&mut self) -> Result<Option<u64>, LogError> {
///         self.row += 1;
///         Ok((self.row <= 3).then_some(self.row))
///     }
///     fn number(&self, column: usize) -> Result<f64, LogError> {
///         let k = (self.row - 1) as f64;
///         Ok(if column == 0 { 0.5 * k } else { 20.0 + k })
///     }
/// }
///
/// let columns = vec![HeaderColumn::parse("time [s]"), HeaderColumn::parse("T_7 [degC]")];
/// let map = LogMap::for_channels(&[], &[Channel::new("T_7", "K")]);
/// let log = LogReader::new(Ramp { columns, row: 0 }, &map)?.read_all()?;
/// assert_eq!(log.record.ts().seconds(), 0.5);
/// assert!((log.record.y(2)[0] - 295.15).abs() < 1e-12);
/// # Ok::<(), LogError>(())
/// ```
pub trait LogSource {
    /// Name of the file, for errors.
    fn file(&self) -> &str;

    /// The columns, in the order of the file. There is at least one; names may occur twice.
    fn columns(&self) -> &[HeaderColumn];

    /// Time between rows in seconds, if the file itself states it.
    fn sample_time(&self) -> Option<f64> {
        None
    }

    /// The column whose cells are dates, if there is one such column: time, where no name says which is.
    fn date_column(&self) -> Option<usize> {
        None
    }

    /// How the file was read where that is not said by the file itself: an encoding, lines that were skipped.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }

    /// Goes on to the next row and returns its number as a person would look it up: the line of a text
    /// file, from 1; nothing at the end.
    ///
    /// # Errors
    ///
    /// Returns an error when the file cannot be read on, or the row has not one cell per column.
    fn next_row(&mut self) -> Result<Option<u64>, LogError>;

    /// The number in a column of the current row, in the unit of the file; NaN where there is no value.
    ///
    /// # Errors
    ///
    /// Returns an error when there is something else than a finite number.
    fn number(&self, column: usize) -> Result<f64, LogError>;
}

impl<S: LogSource + ?Sized> LogSource for Box<S> {
    fn file(&self) -> &str {
        (**self).file()
    }

    fn columns(&self) -> &[HeaderColumn] {
        (**self).columns()
    }

    fn sample_time(&self) -> Option<f64> {
        (**self).sample_time()
    }

    fn date_column(&self) -> Option<usize> {
        (**self).date_column()
    }

    fn notes(&self) -> Vec<String> {
        (**self).notes()
    }

    fn next_row(&mut self) -> Result<Option<u64>, LogError> {
        (**self).next_row()
    }

    fn number(&self, column: usize) -> Result<f64, LogError> {
        (**self).number(column)
    }
}

/// A file cannot be read on: the operating system does not let it, or what it holds is damaged.
pub(crate) fn cannot_read(file: &str, error: &io::Error) -> LogError {
    let file = file.to_owned();
    match error.get_ref().and_then(|inner| inner.downcast_ref::<Unsound>()) {
        Some(Unsound { format, found }) => LogError::Damaged { file, format, found: found.clone() },
        None => LogError::Io { file, action: FileAction::Read, kind: error.kind() },
    }
}

/// What a reader between the file and its text finds wrong.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("expected sound {format} data, {found}")]
pub(crate) struct Unsound {
    pub format: &'static str,
    pub found: String,
}
