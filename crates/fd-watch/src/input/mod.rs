//! From lines of text to rows of numbers: which column is time, unit and channel, in CSV and NDJSON.

mod cells;
mod columns;
mod csv_line;
mod draft;
mod ndjson;
mod rows;
mod runs;

pub(crate) use self::runs::Runs;
pub use self::{
    columns::{ColumnsError, InputMap},
    rows::{Format, Row, RowReader},
};
