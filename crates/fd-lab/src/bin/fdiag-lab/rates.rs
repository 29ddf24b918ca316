//! `fdiag-lab rates`: do stated rates of false alarms hold?

use fd_console::{
    failure::{ExitCode, Failure},
    say::{remark, say},
};
use fd_lab::{
    compare::CompareConfig,
    rates::{Plan, Rate, detectors, measure},
};
use fdiag::spec::StartSpec;

use super::args::RatesArgs;

/// The rate that is stated, of a run.
const STATED: f64 = 0.05;

pub(crate) fn run(args: &RatesArgs) -> Result<ExitCode, Failure> {
    let mut columns: Vec<(String, Vec<Rate>)> = Vec::new();
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
    say(&table(&columns))?;
    Ok(ExitCode::SUCCESS)
}

/// Runs with an alarm in per cent, plants and starts as rows.
fn table(columns: &[(String, Vec<Rate>)]) -> String {
    let Some((_, first)) = columns.first() else { return String::new() };
    let cells = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let heading = first.iter().map(|rate| rate.detector.to_owned());
    let mut text = cells([String::from("plant, start")].into_iter().chain(heading).collect());
    text.push_str(&cells(vec!["---".to_owned(); first.len() + 1]));
    for (name, rates) in columns {
        let shown = rates.iter().map(|rate| match rate.refused.len() {
            0 => rate.share.text(),
            refused => format!("{} ({refused} refused)", rate.share.text()),
        });
        text.push_str(&cells([name.clone()].into_iter().chain(shown).collect()));
    }
    let reasons = columns.iter().flat_map(|(name, rates)| {
        rates.iter().filter_map(move |rate| {
            let reason = rate.refused.first()?;
            Some(format!("\n{name}, {}: {reason}\n", rate.detector))
        })
    });
    text.extend(reasons);
    text
}
