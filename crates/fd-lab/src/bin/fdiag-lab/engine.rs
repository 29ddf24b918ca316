//! `fdiag-lab engine`: the benchmark.

use std::{fs, path::Path, time::Instant};

use fd_lab::engine::{Benchmark, EngineConfig, EngineStudyError};
use fd_log::write_log;
use fd_model::{figure, file::write_atomically};
use fd_report::Table;

use fd_console::{
    failure::{ExitCode, Failure},
    output::Output,
    pool::pool,
    progress::Bar,
    say::say,
};

use super::args::EngineArgs;

/// Memory that an engine needs until the report is written, in bytes: results of 2 kB and their text of 3 kB
/// (measured with 240 engines), the text in the page as well.
const TRIAL_BYTES: f64 = 8000.0;
/// Size of the pictures that are written as files, in pixels.
const PICTURE_SIZE: (u32, u32) = (720, 400);

pub(crate) fn run(args: &EngineArgs) -> Result<ExitCode, Failure> {
    let config = configuration(args)?;
    if args.print_config {
        say(&config.to_toml().map_err(Failure::analysis)?)?;
        return Ok(ExitCode::SUCCESS);
    }
    if let Some(directory) = &args.write_files {
        return write_files(args, config, directory).map(|()| ExitCode::SUCCESS);
    }
    let output = Output::prepare(&args.output)?;
    let pool = pool(args.output.threads)?;
    let refused = |error| refusal(args, &error);
    let benchmark = Benchmark::new(config).map_err(refused)?;
    let begun = Instant::now();
    let progress = Bar::new("engines").within(&args.patience, TRIAL_BYTES);
    let study = pool.install(|| benchmark.study(&progress)).map_err(refused)?;
    progress.finish()?;
    let seconds = begun.elapsed().as_secs_f64();
    let first = study.trials.first().map_or(benchmark.config().first_seed, |trial| trial.seed);
    let example = benchmark.example(first).map_err(Failure::analysis)?;

    let mut pictures = example.pictures();
    pictures.push(study.ratio_picture());
    for named in &pictures {
        let svg =
            named.picture.to_svg(PICTURE_SIZE.0, PICTURE_SIZE.1).map_err(Failure::analysis)?;
        output.write(&format!("{}.svg", named.file), &svg)?;
    }
    let mut page = study.page(&example).map_err(Failure::analysis)?;
    page.heading("Configuration");
    page.details("Show all settings", study.config.to_toml().map_err(Failure::analysis)?);
    let mut tables = study.tables();
    let mut time = Table::new("Time", &["engines", "total [s]", "per engine [ms]"]);
    let engines = study.trials.len() + study.failed.len();
    time.push([engines.to_string(), figure(seconds), figure(1e3 * seconds / engines as f64)]);
    tables.push(time);
    output.finish(&study.headline(), &tables, page, &study, args.config.as_deref().as_slice())?;
    Ok(ExitCode::SUCCESS)
}

/// Healthy runs besides the one that the bias is learned from.
const MORE_HEALTHY_RUNS: usize = 2;

/// The first seed as a user would have it.
fn write_files(args: &EngineArgs, config: EngineConfig, directory: &Path) -> Result<(), Failure> {
    let refused = |error| refusal(args, &error);
    let first = config.first_seed;
    let benchmark = Benchmark::new(config).map_err(refused)?;
    let files = benchmark.user_files(first, MORE_HEALTHY_RUNS).map_err(refused)?;
    let failed = |error: &dyn std::fmt::Display| Failure::output(directory, error);
    fs::create_dir_all(directory).map_err(|error| failed(&error))?;
    files.model.write(directory.join("model.toml")).map_err(|error| failed(&error))?;
    let spec = files.spec.to_toml().map_err(Failure::analysis)?;
    let path = directory.join("spec.toml");
    write_atomically(&path, |out| out.write_all(spec.as_bytes()))
        .map_err(|error| failed(&error))?;
    for (k, record) in files.healthy.iter().enumerate() {
        let name = format!("healthy-{}.csv", k + 1);
        write_log(directory.join(name), record).map_err(|error| failed(&error))?;
    }
    write_log(directory.join("today.csv"), &files.faulty).map_err(|error| failed(&error))
}

fn configuration(args: &EngineArgs) -> Result<EngineConfig, Failure> {
    let mut config = match &args.config {
        None => EngineConfig::default(),
        Some(file) => EngineConfig::read(file).map_err(Failure::of_input)?,
    };
    if let Some(seeds) = args.seeds {
        config.seeds = seeds;
    }
    if let Some(first) = args.first_seed {
        config.first_seed = first;
    }
    Ok(config)
}

/// A setting that cannot be is the fault of the configuration file, all else of what it asks for.
fn refusal(args: &EngineArgs, error: &EngineStudyError) -> Failure {
    let setting = matches!(
        error,
        EngineStudyError::Version { .. }
            | EngineStudyError::Setting { .. }
            | EngineStudyError::None { .. }
            | EngineStudyError::UnknownSensor { .. }
            | EngineStudyError::Limit(_)
    );
    match &args.config {
        Some(file) if setting => Failure::input(file, error),
        _ => Failure::analysis(error),
    }
}
