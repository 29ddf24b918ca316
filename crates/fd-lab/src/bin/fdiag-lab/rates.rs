//! `fdiag-lab rates`: do stated rates of false alarms hold?

use std::fmt::Write;

use fd_console::{
    failure::{ExitCode, Failure},
    say::{remark, say},
};
use fd_lab::{
    compare::CompareConfig,
    rates::{Measured, Plan, detectors, measure},
};
use fd_model::figure;
use fdiag::spec::StartSpec;

use super::args::RatesArgs;

/// The rate that is stated, of a run.
const STATED: f64 = 0.05;

pub(crate) fn run(args: &RatesArgs) -> Result<ExitCode, Failure> {
    let mut columns: Vec<(String, Measured)> = Vec::new();
    for file in &args.config {
        let mut config = CompareConfig::read(file).map_err(Failure::of_input)?;
        if let Some(folder) = file.parent() {
            config.begin_in(folder);
        }
        config.first_seed = args.first_seed;
        for start in [StartSpec::Fitted, StartSpec::Training] {
            let plan = Plan {
                plants: args.seeds,
                healthy: args.healthy,
                fresh: args.fresh,
                learn_share: 0.7,
                settle_s: args.settle,
                tolerance: args.tolerance,
                start,
            };
            let name = config.scenarios.first().map_or("", |scenario| &scenario.name);
            let column = match start {
                StartSpec::Fitted => format!("{name}, fitted"),
                StartSpec::Training => format!("{name}, training"),
            };
            remark(&column);
            let found = measure(&config, &plan, &detectors(STATED, config.samples_of_run()));
            columns.push((column, found.map_err(|error| Failure::input(file, error))?));
        }
    }
    say(&format!("{}\n{}", table(&columns), left(&columns)))?;
    Ok(ExitCode::SUCCESS)
}

/// Runs with an alarm in per cent, plants and starts as rows.
fn table(columns: &[(String, Measured)]) -> String {
    let Some((_, first)) = columns.first() else { return String::new() };
    let cells = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let heading = first.rates.iter().map(|rate| rate.detector.to_owned());
    let mut text = cells([String::from("plant, start")].into_iter().chain(heading).collect());
    text.push_str(&cells(vec!["---".to_owned(); first.rates.len() + 1]));
    for (name, measured) in columns {
        let shown = measured.rates.iter().map(|rate| match rate.refused.len() {
            0 => rate.share.text(),
            refused => format!("{} ({refused} refused)", rate.share.text()),
        });
        text.push_str(&cells([name.clone()].into_iter().chain(shown).collect()));
    }
    let reasons = columns.iter().flat_map(|(name, measured)| {
        measured.rates.iter().filter_map(move |rate| {
            let reason = rate.refused.first()?;
            Some(format!("\n{name}, {}: {reason}\n", rate.detector))
        })
    });
    text.extend(reasons);
    text
}

/// What compensation leaves of healthy runs, plant by plant.
fn left(columns: &[(String, Measured)]) -> String {
    let mut text = String::from(
        "What is left of the rms residual of fresh healthy runs, of that without compensation and of that without the mean of \
         the residual that was learned from:\n\n| plant, start | bias | of all | of what a constant leaves |\n|---|---|---|---|\n",
    );
    for (name, measured) in columns {
        for plant in &measured.left {
            let _ = writeln!(
                text,
                "| {name} | {} | {} | {} |",
                plant.bias,
                figure(plant.of_all),
                figure(plant.of_constant)
            );
        }
    }
    text
}
