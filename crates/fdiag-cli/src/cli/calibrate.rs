//! `fdiag calibrate`: all uncertain parameters of a simulator from logs, as a table.

use std::{fmt::Write as _, path::PathBuf};

use clap::Args;
use fd_log::LogMap;
use fd_report::Table;
use fdiag::{
    gap_study::{CalibratedModel, Named, Request, calibrate, words::standing},
    model::{Disorder, figure},
};

use super::{
    failure::{ExitCode, Failure},
    given::given,
    refusal::refusal,
    say::{remark, say},
};

pub(crate) const CALIBRATE_HELP: &str = "\
Examples:
  fdiag calibrate --model cart.toml --log monday.csv --log friday.csv
  fdiag calibrate --model cart.toml --log monday.csv --write calibrated.toml
  fdiag calibrate --model cart.toml --log monday.csv --tolerance m=0.2 --json";

/// Correlations from which two parameters are said to make up for each other.
const CORRELATED: f64 = 0.9;

#[derive(Debug, Args)]
pub(crate) struct CalibrateArgs {
    /// Model file of the simulator (TOML)
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// Log of the real system; may be repeated, all are fitted together
    #[arg(long = "log", value_name = "FILE", required = true)]
    logs: Vec<PathBuf>,
    /// Column map of the logs (TOML); channels that it does not name are found by name
    #[arg(long, value_name = "FILE")]
    columns: Option<PathBuf>,
    /// How well a parameter is known, relative to its value, instead of what the model says; 0 for exactly
    #[arg(long, value_name = "NAME=SHARE")]
    tolerance: Vec<Named>,
    /// Standard deviation of the noise of an output, in its unit, instead of what the model says
    #[arg(long, value_name = "OUTPUT=SIGMA")]
    noise: Vec<Named>,
    /// Drop rows whose time is not later than that of the row before, instead of refusing the log
    #[arg(long)]
    drop_disorder: bool,
    /// Write the model with the calibrated values to this file
    #[arg(long, value_name = "FILE")]
    write: Option<PathBuf>,
    /// Print JSON instead of tables
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &CalibrateArgs) -> Result<ExitCode, Failure> {
    let plain = Request::new(&args.model, &args.logs);
    let mut resample = plain.resample;
    resample.disorder = if args.drop_disorder { Disorder::Drop } else { Disorder::Reject };
    let request = Request {
        columns: given(args.columns.as_deref(), LogMap::read)?,
        tolerances: args.tolerance.clone(),
        noise: args.noise.clone(),
        resample,
        ..plain
    };
    let found = calibrate(&request).map_err(|error| refusal(&error))?;
    let text = if args.json {
        serde_json::to_string_pretty(&found).map_err(Failure::analysis)? + "\n"
    } else {
        describe(&found)
    };
    say(&text)?;
    if let Some(file) = &args.write {
        std::fs::write(file, &found.text)
            .map_err(|error| Failure::input(file, format!("cannot be written: {error}")))?;
        remark(&format!("{} has the calibrated values.", file.display()));
    }
    Ok(ExitCode::SUCCESS)
}

fn describe(found: &CalibratedModel) -> String {
    let mut text = format!("{}\n\n", found.headline);
    let mut table = Table::new(
        "Parameters",
        &["parameter", "unit", "stated", "calibrated", "error", "known to", "these logs"],
    );
    for p in &found.calibration.parameters {
        table.push([
            p.name.clone(),
            p.unit.clone(),
            figure(p.nominal),
            figure(p.value),
            figure(p.standard_error),
            format!("{} % of before", figure(100.0 * p.of_prior)),
            standing(p.standing).to_owned(),
        ]);
    }
    let _ = writeln!(text, "{}", table.to_text(110));
    for open in &found.calibration.open {
        if let [_, _, ..] = open.parts[..] {
            let parts: Vec<String> =
                open.parts.iter().map(|(name, part)| format!("{part:+.2} {name}")).collect();
            let _ = writeln!(
                text,
                "Open, in standard deviations of what was known: {} (known to {} % of before)",
                parts.join(" "),
                figure(100.0 * open.of_prior)
            );
        }
    }
    let names: Vec<&str> = found.calibration.parameters.iter().map(|p| p.name.as_str()).collect();
    for (i, row) in found.calibration.correlations.iter().enumerate() {
        for (j, correlation) in row.iter().enumerate().take(i) {
            if CORRELATED < correlation.abs() {
                let _ = writeln!(
                    text,
                    "Errors of {} and {} are correlated by {correlation:.2}",
                    names[j], names[i]
                );
            }
        }
    }
    let mut table =
        Table::new("Outputs (rms)", &["output", "unit", "noise", "as stated", "calibrated"]);
    for output in &found.calibration.outputs {
        table.push([
            output.name.clone(),
            output.unit.clone(),
            figure(output.noise),
            figure(output.before),
            figure(output.after),
        ]);
    }
    let _ = writeln!(text, "{}", table.to_text(110));
    text
}
