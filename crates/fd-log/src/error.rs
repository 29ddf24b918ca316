//! What can be wrong with a log.

use std::io;

use fd_core::memory::MemoryError;
use fd_model::{Shown, ShownList, ShownMessage, TimeBaseError, file::FileAction, unit::UnitError};
use thiserror::Error;

use crate::{
    hints::{all_of, because, is_comma, no_time, of_column, unclear_date},
    map::RowRule,
};

/// A log cannot be read or written. Rows are lines of the file, counted from 1, as an editor
/// shows them.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum LogError {
    /// The operating system refuses.
    #[error("{file}: cannot {action}: {}", because(*kind))]
    Io {
        /// Name of the file.
        file: String,
        /// What was tried.
        action: FileAction,
        /// Kind of the refusal.
        kind: io::ErrorKind,
    },
    /// A file is not what its name or its first bytes say, or is cut off.
    #[error("{file}: expected sound {format} data, {}", Shown(found))]
    Damaged {
        /// Name of the file.
        file: String,
        /// The format that was expected.
        format: &'static str,
        /// What is wrong with it.
        found: String,
    },
    /// A file would take more memory than a log may, or than the system gives.
    #[error("{file}: {}", ShownMessage(&error.to_string()))]
    TooLarge {
        /// Name of the file.
        file: String,
        /// Which part of it, how much it may be and how much it is.
        error: MemoryError,
    },
    /// The format is known, and its reader was left out of this program.
    #[error("{file}: this program was built without its reader of {format} (feature `{feature}`)")]
    NotBuilt {
        /// Name of the file.
        file: String,
        /// Name of the format.
        format: &'static str,
        /// Feature that builds the reader.
        feature: &'static str,
    },
    /// A folder or archive holds nothing that can be read as a log.
    #[error("{file}: expected {expected}, {}", ShownMessage(found))]
    NoLog {
        /// Name of the file.
        file: String,
        /// What would have been a log.
        expected: &'static str,
        /// What is there.
        found: String,
    },
    /// What a name stands for is in the file, but is no column of numbers.
    #[error(
        "column `{}` of {file}: expected one number per row, found {}",
        Shown(column),
        ShownMessage(reason)
    )]
    Unfit {
        /// Name of the file.
        file: String,
        /// The name.
        column: String,
        /// What it is instead.
        reason: String,
    },
    /// Columns were taken at different instants, and nobody says how they are to be brought together.
    #[error(
        "{file}: the columns come from topics with clocks of their own: {}; state in the column map whose clock \
         counts and how old a value of the others may be: merge = {{ clock = \"...\", max_age_s = ... }}",
        ShownList(clocks)
    )]
    SeveralClocks {
        /// Name of the file.
        file: String,
        /// The topics, with rows and steps.
        clocks: Vec<String>,
    },
    /// The topic whose clock should count is not there.
    #[error(
        "{file}: there is no topic `{}` to take the clock of; the topics are {}",
        Shown(clock),
        ShownList(known)
    )]
    NoClock {
        /// Name of the file.
        file: String,
        /// Topic that was looked for.
        clock: String,
        /// Topics there are.
        known: Vec<String>,
    },
    /// A channel is said to be constant, and something else besides.
    #[error(
        "{file}: channel `{}`: expected either a finite `constant` or a `column`, found {found}{}",
        Shown(channel),
        column.as_ref().map_or(String::new(), |c| format!(" and column `{}`", Shown(c)))
    )]
    Constant {
        /// Name of the file.
        file: String,
        /// Name of the channel.
        channel: String,
        /// The constant.
        found: f64,
        /// The column, if there is one.
        column: Option<String>,
    },
    /// An expression for a channel or a rule about rows is none, or stands beside a column or a constant.
    #[error("{file}: {place}: expression: {problem}")]
    Expression {
        /// Name of the file.
        file: String,
        /// The channel, or `rows`.
        place: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The age up to which values are held is no age.
    #[error("{file}: `merge.max_age_s`: expected a number of seconds from 0 on, found {found}")]
    Age {
        /// Name of the file.
        file: String,
        /// What the map says.
        found: f64,
    },
    /// There is not a single byte, or only comments.
    #[error("{file}: expected a header and rows, found an empty file")]
    Empty {
        /// Name of the file.
        file: String,
    },
    /// There is a header and nothing else.
    #[error("{file}: expected rows after the header, found none")]
    NoRows {
        /// Name of the file.
        file: String,
    },
    /// The rules about rows let none through.
    #[error("{file}: expected rows that fit {}, found none", all_of(rules))]
    NoneSelected {
        /// Name of the file.
        file: String,
        /// The rules.
        rules: Vec<RowRule>,
    },
    /// The log was written in a version of the format that is not known.
    #[error("{file}, row 1: expected log format version 1, found {}", Shown(found))]
    Version {
        /// Name of the file.
        file: String,
        /// Version that the file claims.
        found: String,
    },
    /// The separator of columns is not a single byte.
    #[error("{file}: expected an ASCII character between columns, the column map says `{}`", Shown(&found.to_string()))]
    Delimiter {
        /// Name of the file.
        file: String,
        /// Separator in the map.
        found: char,
    },
    /// A cell or header is no text.
    #[error("{file}, row {row}: expected text in UTF-8 or Windows-1252, found {}", Shown(found))]
    NotText {
        /// Name of the file.
        file: String,
        /// Line of the file.
        row: u64,
        /// What was found.
        found: String,
    },
    /// A column is not there.
    #[error(
        "{file}: there is no column `{}`{}; the columns are {}",
        Shown(column),
        nearest.as_ref().map_or(String::new(), |n| format!(", did you mean `{}`?", Shown(n))),
        ShownList(known)
    )]
    MissingColumn {
        /// Name of the file.
        file: String,
        /// Column that was looked for.
        column: String,
        /// The column with the most similar name, if one is similar.
        nearest: Option<String>,
        /// Columns there are.
        known: Vec<String>,
    },
    /// No column looks like time, and no sample time is given.
    #[error("{file}: {}", no_time(known))]
    NoTime {
        /// Name of the file.
        file: String,
        /// Columns there are.
        known: Vec<String>,
    },
    /// A name fits several columns.
    #[error("{file}: `{}` fits several columns: {}", Shown(column), ShownList(matches))]
    AmbiguousColumn {
        /// Name of the file.
        file: String,
        /// Name that was looked for.
        column: String,
        /// The columns that it fits.
        matches: Vec<String>,
    },
    /// The map names no output.
    #[error("{file}: the column map names no output")]
    NoOutputs {
        /// Name of the file.
        file: String,
    },
    /// The header and the map give different units to a column.
    #[error(
        "column `{}` of {file}: the header says [{}], the column map says [{}]",
        Shown(column),
        Shown(header),
        Shown(map)
    )]
    UnitConflict {
        /// Name of the file.
        file: String,
        /// Name of the column.
        column: String,
        /// Unit in the header.
        header: String,
        /// Unit in the map.
        map: String,
    },
    /// A column has a unit of the wrong kind.
    #[error("column `{}` of {file}: {}", Shown(column), Shown(&source.to_string()))]
    Unit {
        /// Name of the file.
        file: String,
        /// Name of the column.
        column: String,
        /// Why it cannot be converted.
        source: UnitError,
    },
    /// A row has more or fewer cells than the header.
    #[error("{file}, row {row}: expected {expected} cells, found {found}")]
    Cells {
        /// Name of the file.
        file: String,
        /// Line of the file.
        row: u64,
        /// Cells of the header.
        expected: usize,
        /// Cells of the row.
        found: usize,
    },
    /// Columns of a log in memory differ in length.
    #[error(
        "{file}: column `{}`: expected {expected} values, as in the others, found {found}",
        Shown(column)
    )]
    Ragged {
        /// Name of the log.
        file: String,
        /// Name of the column.
        column: String,
        /// Values of the columns before.
        expected: usize,
        /// Values of this one.
        found: usize,
    },
    /// A cell is not a number.
    #[error(
        "column `{}` of {file}, row {row}: expected a finite number, found `{}`{}",
        Shown(column),
        Shown(found),
        if is_comma(found) { ": with `decimal_comma = true` in a column map?" } else { "" }
    )]
    Number {
        /// Name of the file.
        file: String,
        /// Name of the column.
        column: String,
        /// Line of the file.
        row: u64,
        /// Text of the cell.
        found: String,
    },
    /// A date may be two, and it matters which.
    #[error("column `{}` of {file}, row {row}: {}", Shown(column), unclear_date(found))]
    UnclearDate {
        /// Name of the file.
        file: String,
        /// Name of the column.
        column: String,
        /// Line of the file.
        row: u64,
        /// Text of the cell.
        found: String,
    },
    /// A row has no time.
    #[error("column `{}` of {file}, row {row}: expected a time, found no value", Shown(column))]
    NoTimeInRow {
        /// Name of the file.
        file: String,
        /// Name of the column.
        column: String,
        /// Line of the file.
        row: u64,
    },
    /// A line of an NDJSON file is not an object of numbers.
    #[error("{file}, row {row}: expected a JSON object of numbers, {}", Shown(found))]
    NotAnObject {
        /// Name of the file.
        file: String,
        /// Line of the file.
        row: u64,
        /// What is wrong with it.
        found: String,
    },
    /// A line of an NDJSON file has a key that the first line has not.
    #[error(
        "{file}, row {row}: expected the keys of the first object, found `{}` besides",
        Shown(key)
    )]
    NewKey {
        /// Name of the file.
        file: String,
        /// Line of the file.
        row: u64,
        /// The key.
        key: String,
    },
    /// A time is not after the one before.
    #[error(
        "column `{}` of {file}, row {row}: expected a time after {before} s, found {time} s",
        Shown(column)
    )]
    NotIncreasing {
        /// Name of the file.
        file: String,
        /// Name of the time column.
        column: String,
        /// Line of the file.
        row: u64,
        /// Time of the row before, in seconds.
        before: f64,
        /// Time that was found, in seconds.
        time: f64,
    },
    /// The times do not make an even time base.
    #[error("{file}{}: {source}", of_column(column.as_ref()))]
    TimeBase {
        /// Name of the file.
        file: String,
        /// The column of time; nothing where rows are counted.
        column: Option<String>,
        /// Why not.
        source: Box<TimeBaseError>,
    },
    /// Two channels of a record would make columns of the same name.
    #[error("{file}: two channels of the record are called `{}`", Shown(column))]
    DuplicateColumn {
        /// Name of the file.
        file: String,
        /// The name.
        column: String,
    },
    /// A name or unit cannot stand in a header.
    #[error(
        "{file}: `{}` would not be read back as channel `{}` with unit `{}`",
        Shown(header),
        Shown(name),
        Shown(unit)
    )]
    Unwritable {
        /// Name of the file.
        file: String,
        /// The header it would have.
        header: String,
        /// Name of the channel.
        name: String,
        /// Unit of the channel.
        unit: String,
    },
}
