//! What is computed from columns, channels or numbers for rules about rows: `expression = "kt*current"` of a column map.
//!
//! The language is that of model files (`docs/model-equations.md`). Names are columns of the file, in its units, or
//! those that the map names and converts in `[[columns]]`; `t` is the time of the row in seconds. A value that is
//! missing makes the result missing, even where the expression would not need it.

use fd_model::{Channel, Shown, nearest, unit::Conversion};
use fd_sim::equation::{Expr, Program, Scope, Workspace};

use crate::{
    columns::{Column, Moment, resolve},
    error::LogError,
    header::HeaderColumn,
    map::{ColumnMap, LogMap},
    source::LogSource,
};

/// The time of a row, in the language of model files.
const TIME: &str = "t";

/// An expression, ready to be computed row by row.
#[derive(Debug)]
pub(super) struct Derived {
    program: Program,
    workspace: Workspace<f64>,
    /// What its names stand for, in the order of the workspace; `None` is the time.
    names: Vec<Option<Column>>,
    /// Whether the time is among them.
    needs_time: bool,
}

/// Names of columns in an expression; none where it is no expression, which is said when it is compiled.
pub(super) fn names(text: &str) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    if let Ok(expression) = Expr::parse(text) {
        expression.visit_names(&mut |name| {
            if name != TIME && name != "pi" && !names.iter().any(|known| known == name) {
                names.push(name.to_owned());
            }
        });
    }
    names
}

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
        let column = resolve(file, header, map, named.unwrap_or(&own));
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

impl Derived {
    /// Whether it is computed from the time of the row, too.
    pub(super) fn needs_time(&self) -> bool {
        self.needs_time
    }

    /// The number of a row, in the unit of the expression; nothing where one of its columns has none.
    pub(super) fn number(
        &mut self,
        source: &impl LogSource,
        now: Moment,
    ) -> Result<Option<f64>, LogError> {
        let Self { program, workspace, names, needs_time } = self;
        let mut is_missing = false;
        for (value, column) in workspace.fast_mut().iter_mut().zip(names) {
            *value = match column {
                Some(column) => column.number(source, now)?,
                None => now.time,
            };
            is_missing |= value.is_nan() && (column.is_some() || *needs_time);
        }
        if is_missing {
            return Ok(None);
        }
        let mut results = [f64::NAN];
        program.run(workspace, &mut results);
        Ok(Some(results[0]))
    }
}
