//! `fdiag log`: what is in a log file, before it is used for anything.

use std::{fmt::Write as _, path::PathBuf};

use clap::{Args, Subcommand};
use fd_log::{ClockInfo, ColumnInfo, LogInfo, LogMap, TableInfo, info};
use fd_report::Table;
use fdiag::model::figure;

use super::{
    failure::{ExitCode, Failure},
    given::given,
    say::say,
};

#[derive(Debug, Subcommand)]
pub(crate) enum LogCommand {
    /// Say what a log file holds: format, columns, rows, time base, rate, gaps, units, and what is doubtful
    ///
    /// Reads the whole file (docs/formats.md lists the formats). Units that the file does not state are guessed from
    /// the names of columns and marked so; nothing is converted by a guess.
    #[command(after_help = INFO_HELP)]
    Info(InfoArgs),
}

const INFO_HELP: &str = "\
Examples:
  fdiag log info monday.csv.gz
  fdiag log info flight.ulg --json
  fdiag log info pusht/episode_3";

#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// A log file, or an episode of a dataset
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Column map (TOML): separators, and which column is time in which unit
    #[arg(long, value_name = "FILE")]
    columns: Option<PathBuf>,
    /// Print JSON instead of tables
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(command: &LogCommand) -> Result<ExitCode, Failure> {
    let LogCommand::Info(args) = command;
    let map = given(args.columns.as_deref(), LogMap::read)?;
    let found = info(&args.file, &map.unwrap_or_default()).map_err(Failure::of_input)?;
    let text = if args.json {
        let json = serde_json::to_string_pretty(&found).map_err(Failure::analysis)?;
        json + "\n"
    } else {
        describe(&found)
    };
    say(&text)?;
    Ok(ExitCode::SUCCESS)
}

fn describe(found: &LogInfo) -> String {
    let mut text = format!("{}: {}", found.file, found.format);
    if let Some(step) = found.sample_time {
        let _ = write!(text, ", a row every {} s as the file states", figure(step));
    }
    text.push('\n');
    for table in &found.tables {
        describe_table(&mut text, table);
    }
    for (name, why) in &found.left {
        let _ = writeln!(text, "left out: `{name}`: {why}");
    }
    for note in &found.notes {
        let _ = writeln!(text, "note: {note}");
    }
    for doubt in &found.doubts {
        let _ = writeln!(text, "DOUBT: {doubt}");
    }
    text
}

fn describe_table(text: &mut String, table: &TableInfo) {
    let name = if table.name.is_empty() { "rows" } else { &table.name };
    let _ = writeln!(text, "\n{name}: {} rows, {} columns", table.rows, table.columns.len());
    if let Some(clock) = &table.clock {
        describe_clock(text, clock);
    }
    let mut columns =
        Table::new("Columns", &["name", "unit", "values", "missing", "least", "most", "doubts"]);
    for column in &table.columns {
        columns.push([
            column.name.clone(),
            unit(column),
            column.values.to_string(),
            column.missing.to_string(),
            figure(column.least),
            figure(column.most),
            column.doubts.join("; "),
        ]);
    }
    let _ = writeln!(text, "{}", columns.to_text(110));
}

fn describe_clock(text: &mut String, clock: &ClockInfo) {
    let column = if clock.column.is_empty() { "of the recording" } else { &clock.column };
    let [first, last, step] = [clock.first_s, clock.last_s, clock.median_step_s].map(figure);
    let _ = writeln!(
        text,
        "time {column}: {first} to {last} s, a row every {step} s ({} Hz)",
        figure(1.0 / clock.median_step_s)
    );
    if !clock.is_even {
        let [shortest, longest] = [clock.shortest_step_s, clock.longest_step_s].map(figure);
        let _ = writeln!(text, "steps of {shortest} to {longest} s, {} gaps", clock.gaps);
    }
    for doubt in &clock.doubts {
        let _ = writeln!(text, "DOUBT: {doubt}");
    }
}

/// The unit that the file states, or the guess with a question mark.
fn unit(column: &ColumnInfo) -> String {
    let guess = column.guess.as_ref().map(|guess| format!("{guess}?"));
    column.unit.clone().or(guess).unwrap_or_default()
}
