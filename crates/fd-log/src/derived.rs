//! What is computed from columns, channels or numbers for rules about rows: `expression = "kt*current"` of a column map.
//!
//! The language is that of model files (`docs/model-equations.md`). Names are columns of the file, in its units, or
//! those that the map names and converts in `[[columns]]`; `t` is the time of the row in seconds. A value that is
//! missing makes the result missing, even where the expression would not need it.

use fd_model::{Channel, Shown, nearest, unit::Conversion};
use fd_sim::equation::{Expr, Program, Scope};

use crate::{
    column::{Column, Derived},
    error::LogError,
    expression::{TIME, names},
    header::HeaderColumn,
    map::{ColumnMap, LogMap},
    plain::plain,
};

/// What is said of a name that is none.
fn unknown(name: &str, header: &[HeaderColumn], map: &LogMap) -> String {
    let known = header.iter().map(|column| column.name.as_str());
    let known = known.chain(map.columns.iter().map(|column| column.name.as_str()));
    let meant = nearest(name, known).into_iter().next();
    let meant = meant.map_or(String::new(), |meant| format!("; did you mean `{meant}`?"));
    format!("`{name}` is no column of the file and none of `columns`{meant}")
}

/// The column that a channel with an expression is, and the channel.
pub(super) fn derived_channel(
    file: &str,
    header: &[HeaderColumn],
    map: &LogMap,
    channel: &ColumnMap,
    text: &str,
) -> Result<(Column, Channel), LogError> {
    let place = format!("channel `{}`", Shown(&channel.name));
    if channel.column.is_some() || channel.constant.is_some() {
        let problem = "expected it alone, found a `column` or `constant` beside it".to_owned();
        return Err(LogError::Expression { file: file.to_owned(), place, problem });
    }
    let column = derived(file, header, map, text, &place)?;
    let unit = channel.unit.as_deref().or(channel.column_unit.as_deref()).unwrap_or("1");
    let from = channel.column_unit.as_deref().unwrap_or(unit);
    let text = format!("{} = {text}", channel.name);
    let conversion = Conversion::between(from, unit).map_err(|source| LogError::Unit {
        file: file.to_owned(),
        column: text.clone(),
        source,
    })?;
    Column { text, conversion, ..column }.into_channel(file, channel, unit)
}

/// What an expression makes of columns; `place` is where it stands in the map, for messages.
pub(super) fn derived(
    file: &str,
    header: &[HeaderColumn],
    map: &LogMap,
    text: &str,
    place: &str,
) -> Result<Column, LogError> {
    let wrong = |problem: String| LogError::Expression {
        file: file.to_owned(),
        place: place.to_owned(),
        problem,
    };
    let expression = Expr::parse(text).map_err(|error| wrong(error.to_string()))?;
    let of_columns = names(text);
    let mut needs_time = false;
    expression.visit_names(&mut |name| needs_time |= name == TIME);
    let mut columns = Vec::new();
    for name in &of_columns {
        let named = map.columns.iter().find(|column| column.name == *name);
        if named.is_some_and(|column| column.expression.is_some()) {
            return Err(wrong(format!(
                "expected a column or a constant `{name}`, found an expression"
            )));
        }
        let own = ColumnMap::new(name, name);
        let column = plain(file, header, named.unwrap_or(&own));
        let column = column.map_err(|error| match (error, named) {
            (LogError::MissingColumn { .. }, None) => wrong(unknown(name, header, map)),
            (error, _) => error,
        });
        columns.push(Some(column?.0));
    }
    columns.push(None);
    let fast = of_columns.into_iter().chain([TIME.to_owned()]).collect();
    let program = Program::compile(&Scope { fast, ..Scope::default() }, &[expression]);
    let program = program.map_err(|error| wrong(error.to_string()))?;
    let mut workspace = program.workspace::<f64>();
    program.prepare(&mut workspace);
    let derived = Some(Box::new(Derived { program, workspace, names: columns, needs_time }));
    Ok(Column { derived, ..Column::new(0, text.to_owned(), Conversion::IDENTITY) })
}
