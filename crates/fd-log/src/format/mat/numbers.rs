//! Arrays of MATLAB as columns.

use crate::{
    error::LogError,
    header::HeaderColumn,
    recording::{Recording, Topic},
};

/// Most columns that a matrix may have.
const MOST_COLUMNS: u64 = 4096;

/// Adds an array of this shape under its name: a vector, lying or standing, is one column, a matrix has one for each of
/// its columns. `values` is asked for `(rows, columns)` only where there are such, and gives them column by column.
pub(super) fn add(
    recording: &mut Recording,
    name: &str,
    shape: &[u64],
    values: &mut dyn FnMut((u64, u64)) -> Result<Vec<f64>, LogError>,
) -> Result<(), LogError> {
    let (rows, across) = match *shape {
        [1, n] | [n, 1] if n > 1 => (n, None),
        [rows, across] if rows > 1 && (1..=MOST_COLUMNS).contains(&across) => (rows, Some(across)),
        _ => {
            let size: Vec<String> = shape.iter().map(u64::to_string).collect();
            // Not by their product, which a damaged file makes larger than any number.
            let why = if shape.contains(&0) {
                "empty".to_owned()
            } else if shape.iter().all(|n| *n == 1) {
                "a single value".to_owned()
            } else {
                format!("an array of {}", size.join(" x "))
            };
            recording.unfit.push((name.to_owned(), why));
            return Ok(());
        }
    };
    let values = values((rows, across.unwrap_or(1)))?;
    let mut topic = Topic::default();
    let rows = usize::try_from(rows).unwrap_or(usize::MAX);
    for (i, column) in values.chunks(rows).enumerate() {
        topic.values.push(column.to_vec());
        let index = across.map_or(String::new(), |_| format!("[{i}]"));
        topic.columns.push(HeaderColumn::parse(&format!("{name}{index}")));
    }
    recording.add_table(topic);
    Ok(())
}
