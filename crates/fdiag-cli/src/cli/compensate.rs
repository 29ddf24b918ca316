//! `fdiag compensate`: a user's own model and logs.

use std::path::{Path, PathBuf};

use crate::logs::{LogStudy, LogStudyError, Request};
use fd_log::LogMap;
use fdiag::{
    core::Limits,
    model::file::LinearModel,
    spec::PipelineSpec,
    training::{TrainingError, settling_time},
};

use super::{
    args::CompensateArgs,
    failure::{ExitCode, Failure},
    given::given,
    output::Output,
    progress::Bar,
    say::say,
};

pub(crate) fn run(args: &CompensateArgs) -> Result<ExitCode, Failure> {
    let spec = given(args.spec.as_deref(), PipelineSpec::read)?;
    let spec = spec.unwrap_or_default();
    if args.print_spec {
        return print(&spec, &args.model);
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
        columns: given(args.columns.as_deref(), LogMap::read)?,
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
    page.details("Show the spec", study.spec.to_toml().map_err(Failure::analysis)?);
    let files = [&args.model].into_iter().chain(&args.healthy).chain(&args.logs);
    let files = files.chain(&args.spec).chain(&args.columns).map(PathBuf::as_path);
    let inputs: Vec<&Path> = files.collect();
    output.finish(&study.headline(), &study.tables(), page, &study, &inputs)?;
    let alarmed = study.logs.iter().any(|log| !log.healthy && log.first_alarm_s.1.is_some());
    Ok(if args.fail_on_alarm && alarmed { ExitCode(1) } else { ExitCode::SUCCESS })
}

/// The spec as it would run on a model, with what it leaves to the model as a comment.
fn print(spec: &PipelineSpec, model: &Path) -> Result<ExitCode, Failure> {
    let model = LinearModel::read(model).map_err(Failure::of_input)?;
    let mut text = spec.to_toml().map_err(Failure::analysis)?;
    let sampled = model.system.sample_time().and_then(|ts| model.system.sampled(ts).ok());
    // What is learned from logs has no settling time before.
    let settling = sampled.and_then(|system| settling_time(spec, &system).ok());
    if spec.settle_s.is_none()
        && let Some(seconds) = settling
    {
        let is = "five time constants of the residual generator on this model";
        text.insert_str(0, &format!("# settle_s = {seconds:?} # {is}\n"));
    }
    say(&text)?;
    Ok(ExitCode::SUCCESS)
}
