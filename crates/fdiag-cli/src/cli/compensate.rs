//! `fdiag compensate`: a user's own model and logs.

use std::path::{Path, PathBuf};

use crate::logs::{LogStudy, LogStudyError, Request};
use fdiag::{core::Limits, training::TrainingError};

use super::{
    args::CompensateArgs,
    failure::{ExitCode, Failure},
    output::Output,
    progress::Bar,
    say::say,
    toml_file,
};

pub(crate) fn run(args: &CompensateArgs) -> Result<ExitCode, Failure> {
    let spec = args.spec.as_deref().map(toml_file::read_spec).transpose()?;
    let spec = spec.unwrap_or_default();
    if args.print_spec {
        say(&toml::to_string(&spec).map_err(Failure::analysis)?)?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut logs = args.logs.clone();
    let mut healthy = args.healthy.clone();
    if healthy.is_empty() {
        healthy.push(logs.remove(0));
    }
    let request = Request {
        model: args.model.clone(),
        healthy,
        logs,
        columns: args.columns.as_deref().map(toml_file::read).transpose()?,
        spec,
        share_to_learn: args.learn_share,
        limits: Limits::default(),
    };
    let output = Output::prepare(&args.output)?;
    let progress = Bar::new("logs");
    let studied = request.read().and_then(|material| LogStudy::run(&material, &progress));
    let (study, traces) = studied.map_err(|error| {
        let reason = error.to_string();
        match error {
            LogStudyError::Training(TrainingError::Limit(_) | TrainingError::Nonlinear(_)) => {
                match &args.spec {
                    Some(spec) => Failure::input(spec, reason),
                    None => Failure::analysis(reason),
                }
            }
            LogStudyError::Training(_) | LogStudyError::Model(_) | LogStudyError::NoExcitation => {
                Failure::analysis(reason)
            }
            _ => Failure::of_input(reason),
        }
    })?;
    progress.finish()?;
    let mut page = study.page(&traces).map_err(Failure::analysis)?;
    page.heading("Settings");
    page.details("Show the spec", toml::to_string(&study.spec).map_err(Failure::analysis)?);
    let files = [&args.model].into_iter().chain(&args.healthy).chain(&args.logs);
    let files = files.chain(&args.spec).chain(&args.columns).map(PathBuf::as_path);
    let inputs: Vec<&Path> = files.collect();
    output.finish(&study.headline(), &study.tables(), page, &study, &inputs)?;
    let alarmed = study.logs.iter().any(|log| !log.healthy && log.first_alarm_s.1.is_some());
    Ok(if args.fail_on_alarm && alarmed { ExitCode(1) } else { ExitCode::SUCCESS })
}
