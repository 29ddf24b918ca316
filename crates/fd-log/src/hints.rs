//! What messages about logs add: conditions as people write them, and what may have been meant.

use std::io;

use fd_model::{Shown, ShownList};

use crate::map::RowRule;

/// Rules about rows, as a column map has them.
pub(crate) fn all_of(rules: &[RowRule]) -> String {
    let shown: Vec<String> = rules.iter().map(|rule| format!("`{rule}`")).collect();
    shown.join(" and ")
}

/// What is said where no column is time; those that may well be are offered.
pub(crate) fn no_time(columns: &[String]) -> String {
    const PARTS: [&str; 6] = ["time", "stamp", "zeit", "date", "datum", "clock"];
    let may_be = |column: &&String| {
        let name = column.to_lowercase();
        *column == "T" || PARTS.iter().any(|part| name.contains(part))
    };
    let offered = columns.iter().find(may_be).map_or(String::new(), |column| {
        format!(", perhaps `time = {{ column = \"{}\" }}`", Shown(column))
    });
    format!(
        "expected a column `time`, `t`, `time_s` or `timestamp`, or `time.column` or `time.sample_time` in a column \
         map{offered}; the columns are {}",
        ShownList(columns)
    )
}

/// What is said of a date that may be two.
pub(crate) fn unclear_date(found: &str) -> String {
    format!(
        "`{}` may have day or month first: state it in a column map: time = {{ date_order = \"day-first\" }} or \
         \"month-first\"",
        Shown(found)
    )
}

/// Whether a text is a number but for its comma.
pub(crate) fn is_comma(text: &str) -> bool {
    text.contains(',') && text.replacen(',', ".", 1).parse::<f64>().is_ok()
}

/// The column of time, where there is one.
pub(crate) fn of_column(column: Option<&String>) -> String {
    column.map_or(String::new(), |column| format!(", time from column `{}`", Shown(column)))
}

/// Why the operating system refuses, in everyday words.
pub(crate) fn because(kind: io::ErrorKind) -> String {
    match kind {
        io::ErrorKind::NotFound => "there is no such file or folder".to_owned(),
        kind => kind.to_string(),
    }
}
