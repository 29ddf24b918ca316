//! Rows from lines, whatever their format.

use super::{
    cells,
    columns::{Bound, ColumnsError, InputMap},
    csv_line,
    draft::Draft,
    ndjson,
};
use crate::message::What;

/// Name of a unit that is the only one.
const ONLY_UNIT: &str = "plant";

/// How samples are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// One JSON object per line.
    #[default]
    Ndjson,
    /// A header and lines of cells.
    Csv,
}

/// One sample as it arrived.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row<'a> {
    /// The unit; `plant` when there is only one.
    pub unit: &'a str,
    /// Time in s.
    pub time: f64,
    /// Inputs, then outputs, in the units of the channels; NaN where a value is missing.
    pub values: &'a [f64],
}

/// Turns lines into rows; what is wrong with a line becomes an event, never an end.
///
/// ```
/// use fd_log::LogMap;
/// use fd_model::Channel;
/// use fd_watch::{Format, InputMap, RowReader};
///
/// let map = LogMap::for_channels(&[Channel::new("u", "V")], &[Channel::new("T", "K")]);
/// let mut rows = RowReader::new(Format::Ndjson, InputMap::new(map).with_units("rig"));
/// assert!(rows.read(br#"{"rig": "a", "t": 0.5, "u": 1, "T [degC]": 20}"#)?);
/// let row = rows.row();
/// assert_eq!((row.unit, row.time, row.values), ("a", 0.5, &[1.0, 293.15][..]));
/// assert!(!rows.read(b"not JSON")?);
/// assert_eq!(rows.take_events().len(), 1);
/// # Ok::<(), fd_watch::ColumnsError>(())
/// ```
#[derive(Clone, Debug)]
pub struct RowReader {
    format: Format,
    header: Option<Header>,
    draft: Draft,
}

/// The first line of a CSV.
#[derive(Clone, Debug)]
struct Header {
    text: String,
    delimiter: char,
    bound: Vec<Bound>,
}

impl RowReader {
    /// Reads lines of this format.
    #[must_use]
    pub fn new(format: Format, map: InputMap) -> Self {
        Self { format, header: None, draft: Draft::new(map) }
    }

    /// Reads the next line, and says whether there is a row in it.
    ///
    /// # Errors
    ///
    /// Returns an error when the header of a CSV lacks columns or has them twice: no line after it could be
    /// understood.
    pub fn read(&mut self, line: &[u8]) -> Result<bool, ColumnsError> {
        self.read_of(None, line)
    }

    /// Reads the next line, of a unit that its source has named.
    ///
    /// # Errors
    ///
    /// As [`RowReader::read`].
    pub fn read_of(&mut self, unit: Option<&str>, line: &[u8]) -> Result<bool, ColumnsError> {
        self.draft.begin();
        if let Some(Err(reason)) = unit.map(|unit| self.draft.set_unit(unit)) {
            self.draft.is_unreadable(&reason);
            return Ok(false);
        }
        let Ok(text) = std::str::from_utf8(line) else {
            self.draft.is_unreadable("it is not UTF-8");
            return Ok(false);
        };
        let text = text.trim_start_matches('\u{feff}').trim_end_matches(['\r', '\n']);
        // Comments are what they are in log files, and CSV that `fdiag` has written begins with one.
        let is_comment = self.format == Format::Csv && text.starts_with('#');
        if text.trim().is_empty() || is_comment {
            return Ok(false);
        }
        let read = match self.format {
            Format::Ndjson => ndjson::read(&mut self.draft, text.as_bytes()),
            Format::Csv => match &self.header {
                None => {
                    self.header = Some(Header::read(text, &mut self.draft)?);
                    return Ok(false);
                }
                // Files that were joined have it again.
                Some(header) if header.text == text => return Ok(false),
                Some(header) => header.cells(text, &mut self.draft),
            },
        };
        if let Err(reason) = read {
            self.draft.is_unreadable(&reason);
            return Ok(false);
        }
        Ok(self.draft.finish())
    }

    /// A line that is longer than whoever read it cares for.
    pub fn skip_long_line(&mut self, most: usize) {
        self.draft.begin();
        self.draft.is_unreadable(&format!("it is longer than {most} bytes"));
    }

    /// The row that was read last.
    #[must_use]
    pub fn row(&self) -> Row<'_> {
        let Draft { unit, time, values, .. } = &self.draft;
        let unit = if unit.is_empty() { ONLY_UNIT } else { unit };
        Row { unit, time: time.unwrap_or(f64::NAN), values }
    }

    /// What was wrong with the lines so far; each is handed out once.
    pub fn take_events(&mut self) -> Vec<What> {
        std::mem::take(&mut self.draft.events)
    }
}

impl Header {
    fn read(text: &str, draft: &mut Draft) -> Result<Self, ColumnsError> {
        let delimiter = draft.columns.map.delimiter().unwrap_or_else(|| csv_line::separator(text));
        let missing = |what: &str, draft: &Draft| ColumnsError::Missing {
            what: what.to_owned(),
            nearest: draft.events.iter().find_map(|event| match event {
                What::UnknownColumn { column, nearest: Some(wanted) } if wanted == what => {
                    Some(column.clone())
                }
                _ => None,
            }),
        };
        let Ok(cells) = csv_line::cells(text, delimiter) else {
            return Err(missing("time", draft));
        };
        let mut bound = Vec::new();
        for cell in &cells {
            bound.push(draft.find(cell.trim())?);
        }
        if !bound.iter().any(|b| matches!(b, Bound::Time(_))) {
            return Err(missing("time", draft));
        }
        if draft.columns.map.has_units() && !bound.iter().any(|b| matches!(b, Bound::Unit)) {
            return Err(missing("the unit", draft));
        }
        for channel in 0..draft.columns.map.channels() {
            if !bound.iter().any(|b| matches!(b, Bound::Channel(i, _) if *i == channel)) {
                return Err(missing(draft.columns.map.wanted(channel), draft));
            }
        }
        Ok(Self { text: text.to_owned(), delimiter, bound })
    }

    fn cells(&self, text: &str, draft: &mut Draft) -> Result<(), String> {
        let cells = csv_line::cells(text, self.delimiter)?;
        if cells.len() != self.bound.len() {
            let (expected, found) = (self.bound.len(), cells.len());
            return Err(format!("expected {expected} cells as in the header, found {found}"));
        }
        let decimal_comma = draft.columns.map.has_decimal_comma();
        for (bound, cell) in self.bound.iter().zip(&cells) {
            match bound {
                Bound::Unknown => {}
                Bound::Unit => draft.set_unit(cell.trim())?,
                bound => draft.set(*bound, cells::read(cell, decimal_comma))?,
            }
        }
        Ok(())
    }
}
