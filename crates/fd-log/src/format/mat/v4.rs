//! MAT-files of version 4, "MAT-File Format" (`MathWorks`), and the results of Modelica tools, which are such files.
//!
//! Every matrix has a head of five words: type, rows, columns, whether it is complex, length of its name. Results of
//! Dymola and `OpenModelica` (`Aclass` is `Atrajectory`) keep names, places and values in matrices of their own; here
//! each variable is a column under its name, with the unit that stands at the end of its description. Where an event
//! has two rows of the same time, the later one counts. Variables that never change have no column.

use super::{damaged::damaged, name::text, numbers};
use crate::{
    error::LogError,
    format::number::Number,
    header::HeaderColumn,
    limit::Budget,
    recording::{Recording, Topic},
};

/// Bytes of a head.
const HEAD: usize = 20;
/// Matrices of a file; Modelica tools write six.
const MOST_MATRICES: usize = 10_000;

/// One matrix, column by column.
struct Matrix {
    name: String,
    rows: usize,
    columns: usize,
    content: Content,
}

enum Content {
    Numbers(Vec<f64>),
    Text(Vec<f64>),
    Other(&'static str),
}

/// Reads the matrices of a file that is in memory.
pub(super) fn read(file: &str, raw: &[u8], left: &mut Budget) -> Result<Recording, LogError> {
    let mut matrices = Vec::new();
    let mut rest = raw;
    while !rest.is_empty() {
        if matrices.len() == MOST_MATRICES {
            return Err(damaged(file, "found too many matrices"));
        }
        let (matrix, behind) = Matrix::read(file, rest, left)?;
        matrices.push(matrix);
        rest = behind;
    }
    if let Some(trajectory) = Trajectory::find(&matrices) {
        return trajectory.read(file, left);
    }
    let mut recording = Recording { file: file.to_owned(), ..Recording::default() };
    for Matrix { name, rows, columns, content } in matrices {
        match content {
            Content::Numbers(values) => {
                let shape = [rows, columns].map(|n| u64::try_from(n).unwrap_or(u64::MAX));
                numbers::add(&mut recording, &name, &shape, &mut |_| Ok(values.clone()))?;
            }
            Content::Text(_) => recording.unfit.push((name, "text".to_owned())),
            Content::Other(why) => recording.unfit.push((name, why.to_owned())),
        }
    }
    recording.with_columns("columns of numbers")
}

impl Matrix {
    fn read<'a>(
        file: &str,
        raw: &'a [u8],
        left: &mut Budget,
    ) -> Result<(Self, &'a [u8]), LogError> {
        let cut = || damaged(file, "the file ends within a matrix");
        let (head, rest) = raw.split_at_checked(HEAD).ok_or_else(cut)?;
        let word = |at: usize, is_big: bool| {
            let bytes = head[4 * at..4 * at + 4].try_into().unwrap_or_default();
            if is_big { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) }
        };
        // The type is a number of four digits: order of bytes, nothing, how numbers are stored, what they are.
        let is_big = word(0, false) > 9999;
        let kind = word(0, is_big);
        let (machine, stored, what) = (kind / 1000, kind / 10 % 10, kind % 10);
        let types = ["f8", "f4", "i4", "i2", "u2", "u1"];
        let stored = types.get(stored as usize).filter(|_| kind <= 4999 && kind / 100 % 10 == 0);
        let is_known = machine == u32::from(is_big) && what <= 2;
        let Some(stored) = stored.filter(|_| is_known) else {
            let found =
                format!("found neither version 5 or 7.3, nor a matrix of version 4 (type {kind})");
            return Err(damaged(file, &found));
        };
        let order = if is_big { '>' } else { '<' };
        let number = Number::parse(&format!("{order}{stored}")).ok_or_else(cut)?;
        let size = |at: usize| usize::try_from(word(at, is_big)).unwrap_or(usize::MAX);
        let (rows, columns, is_complex, length) = (size(1), size(2), size(3), size(4));
        let (name, rest) = rest.split_at_checked(length).ok_or_else(cut)?;
        let name = text(name);
        let cells = rows.checked_mul(columns).ok_or_else(cut)?;
        let bytes = cells.checked_mul(number.bytes).ok_or_else(cut)?;
        let parts = if is_complex == 0 { 1 } else { 2 };
        let (data, rest) = bytes
            .checked_mul(parts)
            .and_then(|bytes| rest.split_at_checked(bytes))
            .ok_or_else(cut)?;
        let shown = format!("matrix `{name}`");
        left.take(&shown, 8 * cells as u64)?;
        let values = || {
            let values = number.values(&shown, data[..bytes].chunks(number.bytes));
            values.map_err(|error| left.refused(error))
        };
        let content = match (what, is_complex) {
            (0, 0) => Content::Numbers(values()?),
            (1, _) => Content::Text(values()?),
            (0, _) => Content::Other("complex numbers"),
            _ => Content::Other("a sparse matrix"),
        };
        Ok((Self { name, rows, columns, content }, rest))
    }

    fn numbers(&self) -> Option<&[f64]> {
        match &self.content {
            Content::Numbers(values) | Content::Text(values) => Some(values),
            Content::Other(_) => None,
        }
    }

    /// The lines of a text: its rows, or its columns where it is transposed.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "letters are numbers of a byte"
    )]
    fn lines(&self, is_transposed: bool) -> Vec<String> {
        let values = self.numbers().unwrap_or_default();
        let (lines, length) =
            if is_transposed { (self.columns, self.rows) } else { (self.rows, self.columns) };
        let at = |line: usize, k: usize| {
            let cell = if is_transposed { line * self.rows + k } else { line + k * self.rows };
            values.get(cell).map_or(0, |letter| *letter as u8)
        };
        let line = |line: usize| text(&(0..length).map(|k| at(line, k)).collect::<Vec<_>>());
        (0..lines).map(|n| line(n).trim_end().to_owned()).collect()
    }

    /// One series of numbers: a column, or a row where it is transposed.
    fn series(&self, index: usize, is_transposed: bool) -> Option<Vec<f64>> {
        let values = self.numbers()?;
        let (count, length) =
            if is_transposed { (self.rows, self.columns) } else { (self.columns, self.rows) };
        let at =
            |k: usize| if is_transposed { index + k * self.rows } else { index * self.rows + k };
        (index < count).then(|| (0..length).map(|k| values[at(k)]).collect())
    }
}

/// The result of a simulation.
struct Trajectory<'a> {
    names: Vec<String>,
    descriptions: Vec<String>,
    places: &'a Matrix,
    tables: [&'a Matrix; 2],
    is_transposed: bool,
}

impl<'a> Trajectory<'a> {
    fn find(matrices: &'a [Matrix]) -> Option<Self> {
        let named = |name: &str| matrices.iter().find(|matrix| matrix.name == name);
        let class = named("Aclass")?.lines(false);
        if class.first()? != "Atrajectory" {
            return None;
        }
        let is_transposed = class.get(3).is_some_and(|form| form == "binTrans");
        Some(Self {
            names: named("name")?.lines(is_transposed),
            descriptions: named("description").map(|text| text.lines(is_transposed))?,
            places: named("dataInfo")?,
            tables: [named("data_1")?, named("data_2")?],
            is_transposed,
        })
    }

    fn read(&self, file: &str, left: &mut Budget) -> Result<Recording, LogError> {
        let mut recording = Recording { file: file.to_owned(), ..Recording::default() };
        let mut topic = Topic::default();
        let time = self.tables[1].series(0, self.is_transposed).unwrap_or_default();
        let is_kept = |row: usize| time.get(row + 1).is_none_or(|next| time[row] < *next);
        for (n, name) in self.names.iter().enumerate() {
            let (table, index, sign) = self.place(n).ok_or_else(|| {
                damaged(file, &format!("found no place of the variable `{name}`"))
            })?;
            let series = self.tables[table].series(index, self.is_transposed).ok_or_else(|| {
                damaged(file, &format!("found no values of the variable `{name}`"))
            })?;
            if table == 0 {
                let value = series.first().map_or(f64::NAN, |value| sign * value);
                recording
                    .unfit
                    .push((name.clone(), format!("a value that never changes: {value}")));
                continue;
            }
            left.take(&format!("variable `{name}`"), 8 * series.len() as u64)?;
            let rows = series.iter().enumerate().filter(|(row, _)| is_kept(*row));
            topic.values.push(rows.map(|(_, value)| sign * value).collect());
            let unit = self.descriptions.get(n).and_then(|text| unit(text));
            topic.columns.push(HeaderColumn { name: name.clone(), text: name.clone(), unit });
        }
        if !topic.columns.is_empty() {
            recording.topics.push(topic);
        }
        recording.with_columns("variables that change")
    }

    /// Table, index in it and sign of a variable; the abscissa is the first series of the second table.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "whole numbers that were looked at"
    )]
    fn place(&self, n: usize) -> Option<(usize, usize, f64)> {
        let values = self.places.numbers()?;
        let at = |part: usize| {
            let cell = if self.is_transposed {
                n * self.places.rows + part
            } else {
                n + part * self.places.rows
            };
            values.get(cell).copied()
        };
        let (table, index) = (at(0)?, at(1)?);
        let is_place = index.is_finite() && index.abs() >= 1.0 && index.abs() < 1e9;
        let table = usize::from(!(1.0..=1.0).contains(&table));
        is_place.then(|| (table, index.abs() as usize - 1, index.signum()))
    }
}

/// The unit at the end of a description: `Torque [N.m]`, with the unit of pictures behind a stroke.
fn unit(description: &str) -> Option<String> {
    let (_, unit) = description.strip_suffix(']')?.rsplit_once('[')?;
    let unit = unit.split('|').next()?.trim().replace('.', " ");
    (!unit.is_empty() && !unit.starts_with('#') && !unit.starts_with(':')).then_some(unit)
}
