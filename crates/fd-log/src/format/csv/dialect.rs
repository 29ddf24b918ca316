//! The form of a table of text, found from its beginning: separator, header, units, decimal sign, columns of dates.

use csv::{ByteRecord, ReaderBuilder};

use super::{
    cell::{DecimalSign, decimal_sign, is_missing, number, text},
    head::Head,
};
use crate::{
    date::{self, Kind},
    error::LogError,
    header::HeaderColumn,
    map::LogMap,
};
use fd_model::unit::KNOWN_UNITS;

/// Separators of columns, in the order in which they win ties.
const DELIMITERS: [u8; 3] = [b';', b'\t', b','];
/// Rows that are looked at.
const LOOKED_AT: usize = 200;

/// How a file is to be read.
#[derive(Debug)]
pub(super) struct Dialect {
    pub delimiter: u8,
    /// Bytes and lines of the block before the header.
    pub skipped: (usize, u64),
    pub columns: Vec<HeaderColumn>,
    /// Whether units stand in the line behind the header.
    pub has_units: bool,
    pub decimal_comma: bool,
    /// Columns that hold dates.
    pub dates: Vec<bool>,
    /// Columns of days and of times of day that are one date.
    pub pair: Option<(usize, usize)>,
    /// The column of dates, if there is one.
    pub date_column: Option<usize>,
    /// What was found and is not said by the file.
    pub notes: Vec<String>,
}

/// A line of the beginning, taken apart.
#[derive(Debug)]
struct Line {
    /// Where it begins, in bytes and lines.
    begin: (usize, u64),
    end: u64,
    cells: ByteRecord,
}

impl Dialect {
    pub(super) fn find(file: &str, head: &Head, map: &LogMap) -> Result<Self, LogError> {
        let given = match map.delimiter {
            Some(found) if found.is_ascii() => Some(found as u8),
            Some(found) => return Err(LogError::Delimiter { file: file.to_owned(), found }),
            None if head.written_here => Some(b','),
            None => None,
        };
        let first = head.block.split(|byte| *byte == b'\n').next().unwrap_or_default();
        let usual = given.unwrap_or_else(|| most_frequent(first));
        let mut delimiter = usual;
        let mut lines = taken_apart(head, usual);
        let mut header = 0;
        let rows = body(&lines[1.min(lines.len())..]);
        let is_table = lines.first().is_none_or(|line| {
            rows.is_none_or(|(cells, _)| cells > 1 && line.cells.len() == cells)
        });
        if !head.written_here && !is_table {
            let candidates: Vec<u8> = given.map_or(DELIMITERS.to_vec(), |given| vec![given]);
            let found = candidates.into_iter().filter_map(|delimiter| {
                let lines = taken_apart(head, delimiter);
                let (cells, rows) = body(&lines).filter(|(cells, _)| *cells > 1)?;
                let header = below_preamble(&lines, cells)?;
                Some((rows, delimiter, lines, header))
            });
            // Of equally many rows the first.
            let best = found.reduce(|best, next| if next.0 > best.0 { next } else { best });
            if let Some((_, by, of, at)) = best {
                (delimiter, lines, header) = (by, of, at);
            }
        }
        let Some(Line { begin, end, cells }) = lines.get(header) else {
            return Err(LogError::Empty { file: file.to_owned() });
        };
        let row = head.lines_before + end;
        let columns = cells.iter().map(|cell| Ok(HeaderColumn::parse(&text(file, row, cell)?)));
        let columns = columns.collect::<Result<Vec<_>, LogError>>()?;
        let mut dialect = Self {
            delimiter,
            skipped: *begin,
            has_units: false,
            decimal_comma: map.decimal_comma,
            dates: vec![false; columns.len()],
            pair: None,
            date_column: None,
            notes: Vec::new(),
            columns,
        };
        if head.is_utf16 {
            dialect.notes.push("the text is UTF-16".to_owned());
        } else if std::str::from_utf8(cells.as_slice()).is_err() {
            dialect.notes.push("the text is no UTF-8, and read as Windows-1252".to_owned());
        }
        if begin.1 > 0 {
            dialect.notes.push(format!("{} lines before the header are skipped", begin.1));
        }
        let rows: Vec<Vec<String>> = lines[header + 1..].iter().map(Line::texts).collect();
        dialect.units(&rows);
        let rows = &rows[usize::from(dialect.has_units).min(rows.len())..];
        dialect.sign(rows);
        dialect.dates(rows);
        Ok(dialect)
    }

    /// Units in the line behind the header: no number in a column of numbers, and one of them a known unit.
    fn units(&mut self, rows: &[Vec<String>]) {
        let [units, next, ..] = rows else { return };
        if units.len() != self.columns.len() || next.len() != self.columns.len() {
            return;
        }
        let of = |text: &str| {
            let inner = text.trim_matches(['[', ']', '(', ')']);
            inner.trim().to_owned()
        };
        let is_known = |text: &String| {
            let unit = of(text);
            !matches!(unit.as_str(), "" | "1" | "-")
                && KNOWN_UNITS.iter().any(|(names, ..)| names.contains(&unit.as_str()))
        };
        let is_value = |text: &str| number(text, true).is_some() || date::kind(text).is_some();
        let fits = |(unit, next): (&String, &String)| {
            is_missing(unit) || !is_value(unit) && (is_value(next) || is_missing(next))
        };
        self.has_units = units.iter().any(is_known) && units.iter().zip(next).all(fits);
        if self.has_units {
            for (column, unit) in self.columns.iter_mut().zip(units) {
                if column.unit.is_none() && !unit.is_empty() {
                    column.unit = Some(of(unit));
                }
            }
            self.notes.push("units are in the line behind the header".to_owned());
        }
    }

    /// A decimal comma, where some cells can be nothing else and none speaks for a point.
    fn sign(&mut self, rows: &[Vec<String>]) {
        if self.decimal_comma || self.delimiter == b',' {
            return;
        }
        let signs = || rows.iter().flatten().map(|cell| decimal_sign(cell));
        self.decimal_comma = signs().any(|sign| sign == DecimalSign::Comma)
            && !signs().any(|sign| sign == DecimalSign::Point);
        if self.decimal_comma {
            self.notes.push("numbers have a decimal comma".to_owned());
        }
    }

    /// Columns of dates, by their first cell that is not empty.
    fn dates(&mut self, rows: &[Vec<String>]) {
        let kinds: Vec<Option<Kind>> = (0..self.columns.len())
            .map(|column| {
                let cells = rows.iter().filter_map(|row| row.get(column));
                let first = cells.into_iter().find(|cell| !is_missing(cell))?;
                if number(first, self.decimal_comma).is_some() { None } else { date::kind(first) }
            })
            .collect();
        self.dates = kinds.iter().map(Option::is_some).collect();
        let only = |kind: Kind| {
            let mut of = (0..kinds.len()).filter(|column| kinds[*column] == Some(kind));
            of.next().filter(|_| of.next().is_none())
        };
        let (day, time) = (only(Kind::Day), only(Kind::Time));
        if !kinds.contains(&Some(Kind::Both)) {
            self.pair = day.zip(time);
        }
        self.date_column = only(Kind::Both).or(time).or(day);
        for (column, _) in self.columns.iter_mut().zip(&kinds).filter(|(_, kind)| kind.is_some()) {
            column.unit = Some("s".to_owned());
        }
        if let Some((day, time)) = self.pair {
            let [day, time] = [day, time].map(|column| &self.columns[column].text);
            self.notes.push(format!("`{time}` is the time of the day in `{day}`"));
        }
    }
}

impl Line {
    fn texts(&self) -> Vec<String> {
        let cell = |cell: &[u8]| String::from_utf8_lossy(cell).trim().to_owned();
        self.cells.iter().map(cell).collect()
    }

    /// Whether one of its cells is a number or a date.
    fn has_value(&self) -> bool {
        let is_value = |text: &String| number(text, true).is_some() || date::kind(text).is_some();
        self.texts().iter().any(is_value)
    }
}

/// The lines of the beginning; the last one only where the file ends with it.
fn taken_apart(head: &Head, delimiter: u8) -> Vec<Line> {
    let mut reader = ReaderBuilder::new();
    reader.delimiter(delimiter).flexible(true).has_headers(false);
    let mut reader = reader.from_reader(head.block.as_slice());
    let mut lines = Vec::new();
    let mut cells = ByteRecord::new();
    while lines.len() <= LOOKED_AT && matches!(reader.read_byte_record(&mut cells), Ok(true)) {
        let at = cells.position().map_or((0, 1), |at| (at.byte(), at.line()));
        let begin = usize::try_from(at.0).unwrap_or(0);
        // Blank lines before it are counted to it.
        let blank = head.block[begin..].iter().take_while(|byte| matches!(byte, b'\r' | b'\n'));
        let (blank, ends) =
            blank.fold((0, 0), |(all, ends), byte| (all + 1, ends + u64::from(*byte == b'\n')));
        let begin = (begin + blank, at.1 - 1 + ends);
        lines.push(Line { begin, end: begin.1 + 1, cells: cells.clone() });
    }
    if !head.is_whole && lines.len() > 1 && lines.len() <= LOOKED_AT {
        lines.pop();
    }
    lines
}

/// How many cells most lines have, and how many lines that are.
fn body(lines: &[Line]) -> Option<(usize, usize)> {
    let counts = lines.iter().map(|line| line.cells.len());
    let with = |cells: usize| lines.iter().filter(|line| line.cells.len() == cells).count();
    counts.max_by_key(|cells| with(*cells)).map(|cells| (cells, with(cells)))
}

/// The header of a table with so many columns: the first of the lines next to each other that end with the first row.
fn below_preamble(lines: &[Line], cells: usize) -> Option<usize> {
    let fits = |at: usize| lines[at].cells.len() == cells;
    let row = (1..lines.len()).find(|at| {
        fits(*at) && lines[*at].has_value() && (*at + 1..lines.len()).take(2).all(fits)
    })?;
    let mut header = (0..row).rev().find(|at| fits(*at))?;
    while header > 0 && fits(header - 1) && lines[header - 1].end == lines[header].begin.1 {
        header -= 1;
    }
    (!lines[header].has_value() || header + 1 == row).then_some(header)
}

/// The separator that occurs most often outside quotes in a line: `,`, `;` or tab.
fn most_frequent(line: &[u8]) -> u8 {
    let mut quoted = false;
    let mut counts = [0_usize; 3];
    for byte in line {
        quoted ^= *byte == b'"';
        if let Some(i) = DELIMITERS.iter().position(|d| d == byte).filter(|_| !quoted) {
            counts[i] += 1;
        }
    }
    // The last of several maxima wins: a comma, when there is no separator at all.
    (0..3).max_by_key(|&i| counts[i]).map_or(b',', |i| DELIMITERS[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separators_are_found_outside_quotes() {
        assert_eq!(most_frequent(b"a,b"), b',');
        assert_eq!(most_frequent(b"\"a,b,c\";d"), b';');
        assert_eq!(most_frequent(b"a\tb\tc"), b'\t');
        assert_eq!(most_frequent(b"alone"), b',');
    }
}
