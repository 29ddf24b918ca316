//! `fdiag-lab compare`: the tournament.

use std::{fs, path::Path};

use fd_lab::compare::{CompareConfig, CompareError, Comparison, begin_anew};
use fd_report::Table;

use fd_console::{
    failure::{ExitCode, Failure},
    output::Output,
    pool::pool,
    progress::Bar,
    provenance::command,
    say::{remark, say},
};

use super::args::CompareArgs;

/// Memory that an entry of an engine needs until the report is written, in bytes: its part of a
/// line of the journal, measured, which is more than its numbers are.
const ENTRY_BYTES: f64 = 400.0;
/// Name of the file of finished engines.
const JOURNAL: &str = "progress.jsonl";

pub(crate) fn run(args: &CompareArgs) -> Result<ExitCode, Failure> {
    let config = configuration(args)?;
    if args.print_config {
        say(&config.to_toml().map_err(Failure::analysis)?)?;
        return Ok(ExitCode::SUCCESS);
    }
    let refused = |error| refusal(args, &error);
    config.check().map_err(refused)?;
    let output = Output::prepare(&args.output)?.compact();
    let journal = args.output.out.join(JOURNAL);
    if args.restart {
        begin_anew(&journal).map_err(refused)?;
    }
    let pool = pool(args.output.threads)?;
    let bytes = config.entries() as f64 * ENTRY_BYTES;
    let (scenarios, engines) = (config.scenarios.len(), config.engines);
    remark(&format!(
        "{} engines: {scenarios} scenarios with {} that set thresholds and {} that are judged, {} entries each",
        scenarios as u64 * (engines.thresholds + engines.test),
        engines.thresholds,
        engines.test,
        config.entries()
    ));
    let shown = Bar::new("engines").within(&args.patience, bytes);
    let comparison = match pool.install(|| Comparison::run(&config, Some(&journal), &shown)) {
        Err(CompareError::Stopped) => return Err(shown.stopped(&journal)),
        done => done.map_err(refused)?,
    };
    shown.finish()?;
    let mut page = comparison.page().map_err(Failure::analysis)?;
    page.heading("Configuration");
    page.details("Show all settings", config.to_toml().map_err(Failure::analysis)?);
    let tables: Vec<Table> = comparison.tables();
    output.write("report.md", &comparison.markdown(&command()))?;
    output.finish(
        &comparison.headline(),
        &tables,
        page,
        &comparison,
        args.config.as_deref().as_slice(),
    )?;
    // Everything in it is in the report now.
    fs::remove_file(&journal).map_err(|error| Failure::output(&journal, error))?;
    Ok(ExitCode::SUCCESS)
}

fn configuration(args: &CompareArgs) -> Result<CompareConfig, Failure> {
    let mut config: CompareConfig = match &args.config {
        None => CompareConfig::default(),
        Some(file) => {
            let mut config = CompareConfig::read(file).map_err(Failure::of_input)?;
            config.begin_in(file.parent().unwrap_or(Path::new("")));
            config
        }
    };
    if let Some(seeds) = args.seeds {
        config.engines.thresholds = seeds;
        config.engines.test = seeds;
    }
    if let Some(first) = args.first_seed {
        config.first_seed = first;
    }
    let known: Vec<&str> = config.scenarios.iter().map(|s| s.name.as_str()).collect();
    if let Some(name) = args.scenario.iter().find(|name| !known.contains(&name.as_str())) {
        let text = format!("there is no scenario `{name}`; there are {}", known.join(", "));
        return Err(Failure::analysis(text));
    }
    if !args.scenario.is_empty() {
        config.scenarios.retain(|scenario| args.scenario.contains(&scenario.name));
    }
    Ok(config)
}

/// A setting that cannot be is the fault of the configuration file.
fn refusal(args: &CompareArgs, error: &CompareError) -> Failure {
    let setting = matches!(
        error,
        CompareError::Version { .. }
            | CompareError::Setting { .. }
            | CompareError::Limit(_)
            | CompareError::Own { .. }
    );
    match &args.config {
        Some(file) if setting => Failure::input(file, error),
        _ if matches!(error, CompareError::Journal(_)) => Failure::of_input(error),
        _ => Failure::analysis(error),
    }
}
