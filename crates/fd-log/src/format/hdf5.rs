//! HDF5 (h5py, netCDF 4, MATLAB 7.3), <https://support.hdfgroup.org/documentation/hdf5/latest/_f_m_t3.html>.
//!
//! A dataset of one dimension is a column under its path, one of two dimensions has columns `name[0]`, `name[1]`..., one
//! of records a column per field. Datasets with equally many rows are one table. The attribute `units` or `unit` is
//! the unit. In a file of MATLAB, fields of a struct are `log.u`, and matrices stand as they do in MATLAB, which
//! writes them transposed.

use std::{collections::BTreeSet, fs::File, io::Read};

use hdf5_reader::{
    Attribute, ByteOrder, Dataset, Datatype, Hdf5File, OpenOptions, error::Error, group::Group,
};

use super::number::Number;
use crate::{
    error::LogError,
    header::HeaderColumn,
    limit::Budget,
    recording::{Recording, Topic},
};

/// Groups within groups.
const DEEPEST: usize = 16;
/// Most columns that a dataset may have.
const MOST_COLUMNS: u64 = 4096;
/// Most datasets and groups of a file.
const MOST_MEMBERS: usize = 100_000;
/// What MATLAB keeps for itself.
const MATLABS_OWN: &str = "#";

/// A file of HDF5.
pub(super) fn read(file: &str, from: File) -> Result<Recording, LogError> {
    Reader::open(file, from, "HDF5", false)
}

/// A file of MATLAB that is HDF5 inside.
pub(super) fn read_matlab(file: &str, from: File) -> Result<Recording, LogError> {
    Reader::open(file, from, "MAT 7.3", true)
}

/// What is read, and what there is still room for.
struct Reader {
    recording: Recording,
    left: Budget,
    format: &'static str,
    is_matlab: bool,
    /// Groups that were visited: a link may lead back.
    seen: BTreeSet<u64>,
    members: usize,
}

/// A part of each element: name, type, and where it begins.
type Field = (Option<String>, Number, usize);

impl Reader {
    fn open(
        file: &str,
        from: File,
        format: &'static str,
        is_matlab: bool,
    ) -> Result<Recording, LogError> {
        let recording = Recording { file: file.to_owned(), ..Recording::default() };
        let left = Budget::of_file(file, &from);
        let seen = BTreeSet::new();
        let mut reader = Self { recording, left, format, is_matlab, seen, members: 0 };
        let length = from.metadata().map_or(0, |about| about.len());
        reader.left.take("the file", length)?;
        let mut raw = Vec::new();
        // Not mapped: a file that is cut off while it is read must not end the program.
        from.take(length).read_to_end(&mut raw).map_err(|e| reader.damaged(&e.into()))?;
        let most = usize::try_from(reader.left.left()).unwrap_or(usize::MAX);
        let options = OpenOptions::default().with_max_read_bytes(most).with_chunk_cache_bytes(0);
        let opened = Hdf5File::from_vec_with_options(raw, options);
        let root = opened.and_then(|opened| opened.root_group());
        let root = root.map_err(|error| reader.damaged(&error))?;
        reader.group(&root, "", 0)?;
        let Self { recording, .. } = reader;
        recording.with_columns("columns of numbers")
    }

    fn damaged(&self, error: &Error) -> LogError {
        let (file, found) = (self.recording.file.clone(), format!("found: {error}"));
        LogError::Damaged { file, format: self.format, found }
    }

    fn group(&mut self, group: &Group, path: &str, depth: usize) -> Result<(), LogError> {
        if depth > DEEPEST || !self.seen.insert(group.address()) {
            return Ok(());
        }
        let (groups, datasets) = group.members().map_err(|error| self.damaged(&error))?;
        self.members += groups.len() + datasets.len();
        if self.members > MOST_MEMBERS {
            let (file, found) = (self.recording.file.clone(), "found too many members".to_owned());
            return Err(LogError::Damaged { file, format: self.format, found });
        }
        for dataset in &datasets {
            self.dataset(dataset, &self.below(path, dataset.name()))?;
        }
        for inner in &groups {
            if self.is_matlab && inner.name().starts_with(MATLABS_OWN) {
                continue;
            }
            let attributes = |name: &str| inner.attribute(name).ok();
            if let Some(why) = self.is_matlab.then(|| matlab_group(attributes)).flatten() {
                self.recording.unfit.push((self.below(path, inner.name()), why));
                continue;
            }
            self.group(inner, &self.below(path, inner.name()), depth + 1)?;
        }
        Ok(())
    }

    /// A name within a group: `log/u`, in MATLAB's words `log.u`.
    fn below(&self, path: &str, name: &str) -> String {
        match (path, self.is_matlab) {
            ("", _) => name.to_owned(),
            (_, true) => format!("{path}.{name}"),
            (_, false) => format!("{path}/{name}"),
        }
    }

    fn dataset(&mut self, dataset: &Dataset, name: &str) -> Result<(), LogError> {
        let mut unfit = |why: String| self.recording.unfit.push((name.to_owned(), why));
        if let Some(why) = self.is_matlab.then(|| matlab_dataset(dataset)).flatten() {
            unfit(why);
            return Ok(());
        }
        let Some(fields) = fields(dataset.dtype()) else {
            unfit("something else than numbers".to_owned());
            return Ok(());
        };
        let mut shape = dataset.shape().to_vec();
        if self.is_matlab {
            shape.reverse();
        }
        // A vector lies or stands in MATLAB, and is one column either way.
        let is_vector = self.is_matlab && shape.len() == 2 && shape.contains(&1);
        let (rows, across) = match shape[..] {
            [a, b] if is_vector && (a, b) != (1, 1) => (a.max(b), None),
            [rows] => (rows, None),
            [rows, across]
                if !is_vector && across.saturating_mul(fields.len() as u64) <= MOST_COLUMNS =>
            {
                (rows, Some(across))
            }
            _ => {
                let is_single = shape.iter().all(|n| *n == 1);
                let size: Vec<String> = shape.iter().map(u64::to_string).collect();
                let array = || format!("an array of {}", size.join(" x "));
                unfit(if is_single { "a single value".to_owned() } else { array() });
                return Ok(());
            }
        };
        let width = match dataset.raw_element_size() {
            Ok(width) => width,
            Err(error) => return Err(self.damaged(&error)),
        };
        let cells = rows.saturating_mul(across.unwrap_or(1));
        let what = format!("dataset `{name}`");
        self.left.take(&what, cells.saturating_mul(8 * fields.len() as u64))?;
        self.left.take(&what, cells.saturating_mul(width as u64))?;
        let raw = match dataset.read_raw_bytes() {
            Ok(raw) => raw,
            // A way of packing that this reader does not know spoils that dataset only.
            Err(error) if error.to_string().contains("unsupported") => {
                let why = format!("data that cannot be unpacked ({error})");
                self.recording.unfit.push((name.to_owned(), why));
                return Ok(());
            }
            Err(error) => return Err(self.damaged(&error)),
        };
        let all = |n: u64| usize::try_from(n).unwrap_or(0);
        let (rows, columns) = (all(rows), all(across.unwrap_or(1)));
        let unit = unit(dataset);
        let mut topic = Topic::default();
        for (field, number, offset) in fields {
            for column in 0..columns {
                let cell = |row: usize| {
                    let cell =
                        if self.is_matlab { column * rows + row } else { row * columns + column };
                    let begin = cell.saturating_mul(width).saturating_add(offset);
                    raw.get(begin..begin.saturating_add(number.bytes)).unwrap_or_default()
                };
                let field = field.as_ref().map_or(String::new(), |field| format!(".{field}"));
                let index = across.map_or(String::new(), |_| format!("[{column}]"));
                let text = format!("{name}{field}{index}");
                topic.columns.push(match &unit {
                    Some(_) => HeaderColumn { name: text.clone(), text, unit: unit.clone() },
                    None => HeaderColumn::parse(&text),
                });
                let values = number.values(&what, (0..rows).map(cell));
                topic.values.push(values.map_err(|error| self.left.refused(error))?);
            }
        }
        self.recording.add_table(topic);
        Ok(())
    }
}

/// Why a group of MATLAB is no struct of columns, by its attributes.
fn matlab_group(attribute: impl Fn(&str) -> Option<Attribute>) -> Option<String> {
    if attribute("MATLAB_sparse").is_some() {
        return Some("a sparse matrix".to_owned());
    }
    matlab_class(attribute, &["struct"])
}

/// Why a dataset of MATLAB is no column: it holds texts, cells, objects or complex numbers by numbers.
fn matlab_dataset(dataset: &Dataset) -> Option<String> {
    const NUMBERS: [&str; 11] = [
        "double", "single", "logical", "int8", "uint8", "int16", "uint16", "int32", "uint32",
        "int64", "uint64",
    ];
    let attribute = |name: &str| dataset.attribute(name).ok();
    // The numbers of what is empty are its dimensions.
    if attribute("MATLAB_empty").is_some() {
        return Some("empty".to_owned());
    }
    if let Datatype::Compound { fields, .. } = dataset.dtype()
        && fields.iter().map(|field| field.name.as_str()).eq(["real", "imag"])
    {
        return Some("complex numbers".to_owned());
    }
    matlab_class(attribute, &NUMBERS)
}

/// What a class of MATLAB is, unless it is one of those that are read.
fn matlab_class(attribute: impl Fn(&str) -> Option<Attribute>, read: &[&str]) -> Option<String> {
    let class = attribute("MATLAB_class").and_then(|class| class.read_string().ok());
    let class = class.map(|class| class.trim_end_matches('\0').trim().to_owned());
    if attribute("MATLAB_object_decode").is_some() {
        return Some(
            class.map_or("an object".to_owned(), |class| format!("an object (`{class}`)")),
        );
    }
    match class?.as_str() {
        class if read.contains(&class) => None,
        "char" => Some("text".to_owned()),
        "cell" => Some("cells".to_owned()),
        "struct" => Some("an array of structs".to_owned()),
        "function_handle" => Some("a function".to_owned()),
        class => Some(format!("an object (`{class}`)")),
    }
}

/// The numbers of an element; nothing for what has none.
fn fields(kind: &Datatype) -> Option<Vec<Field>> {
    if let Datatype::Compound { fields, .. } = kind {
        let numbers = fields.iter().filter_map(|field| {
            let offset = usize::try_from(field.byte_offset).ok()?;
            Some((Some(field.name.clone()), number(&field.datatype)?, offset))
        });
        let numbers: Vec<Field> = numbers.collect();
        return (!numbers.is_empty()).then_some(numbers);
    }
    number(kind).map(|number| vec![(None, number, 0)])
}

fn number(kind: &Datatype) -> Option<Number> {
    let (letter, size, order) = match kind {
        Datatype::FloatingPoint { size, byte_order } => ('f', size, byte_order),
        Datatype::FixedPoint { size, signed: true, byte_order } => ('i', size, byte_order),
        Datatype::FixedPoint { size, signed: false, byte_order } => ('u', size, byte_order),
        // Truth values of h5py.
        Datatype::Enum { base, .. } => return number(base),
        _ => return None,
    };
    let order = if *order == ByteOrder::BigEndian { '>' } else { '<' };
    Number::parse(&format!("{order}{letter}{size}"))
}

/// The unit that a dataset states.
fn unit(dataset: &Dataset) -> Option<String> {
    let stated = ["units", "unit"].iter().find_map(|name| dataset.attribute(name).ok())?;
    let unit = stated.read_string().ok()?.trim().to_owned();
    // Times of netCDF (CF conventions): what they count from does not matter.
    let unit = unit.split(" since ").next().unwrap_or_default();
    let unit = match unit {
        "second" | "seconds" => "s",
        "milliseconds" => "ms",
        "microseconds" => "us",
        "nanoseconds" => "ns",
        "minutes" => "min",
        "hours" => "h",
        other => other,
    };
    (!unit.is_empty()).then(|| unit.to_owned())
}
