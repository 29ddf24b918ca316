//! `fdiag gap`: a user's simulator and logs of the real system.

use std::{
    path::{Path, PathBuf},
    sync::{Arc, atomic::AtomicBool},
    time::{Duration, Instant},
};

use fd_log::LogMap;
use fd_page::{page, tables};
use fdiag::{
    core::Limits,
    effect::text::TextEffects,
    gap_study::{
        Answered, Compared, GapError, GapStudy, HeldOutChoice, Request, ResampleChoice, Subject,
        Timing,
    },
    model::{Disorder, figure},
    sim::outside::Counts,
};

use signal_hook::{consts::SIGINT, flag};

use super::{
    args::GapArgs,
    each,
    failure::{ExitCode, Failure},
    given::given,
    output::Output,
    pool::pool,
    progress::Stages,
    refusal::refusal,
    say::{complain, remark, say},
};

/// Exit code of a program that Ctrl-C has ended, as shells have it.
const INTERRUPTED: i32 = 130;

pub(crate) fn run(args: &GapArgs, limit: Option<Duration>) -> Result<ExitCode, Failure> {
    let request = request(args)?;
    if args.print_model {
        say(&Subject::of(&request).map_err(|error| refusal(&error))?.to_string())?;
        return Ok(ExitCode::SUCCESS);
    }
    let is_stopped = interrupted()?;
    let output = Output::prepare(&args.output)?;
    let pool = pool(args.output.threads)?;
    let progress = Stages::new().stopped_by(is_stopped, limit);
    let timed = |request: &Request| -> Result<GapStudy, GapError> {
        let begun = Instant::now();
        let mut study = pool.install(|| GapStudy::run(request, &progress))?;
        let threads = pool.current_num_threads();
        study.report.timing = Timing { seconds: begun.elapsed().as_secs_f64(), threads };
        Ok(study)
    };
    if args.each {
        let studies = each::studies(&request, &output, &args.output.out, timed)?;
        progress.finish();
        return compared(&studies, &output, &inputs(args));
    }
    let study = timed(&request);
    progress.finish();
    let study = study.map_err(|error| refusal(&error))?;
    let page = page(&study).map_err(Failure::analysis)?;
    for model in &study.report.models {
        output.write(&model.file, &model.text)?;
    }
    let report = &study.report;
    output.finish(&report.headline, &tables(report), page, report, &inputs(args))?;
    if let Some((counts, trouble)) = &study.outside {
        remark(&work(counts));
        if let Some(trouble) = trouble {
            complain(&format!("The simulator was in trouble: {trouble}"));
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// What the answers of several logs agree on; one that has no answer is told beside the others.
fn compared(
    studies: &[each::Studied],
    output: &Output<'_>,
    inputs: &[&Path],
) -> Result<ExitCode, Failure> {
    if let [(_, Err(error)), ..] = studies
        && studies.iter().all(|(_, study)| study.is_err())
    {
        return Err(refusal(error));
    }
    let mut answered: Vec<Answered<'_>> = Vec::with_capacity(studies.len());
    for (name, study) in studies {
        let report = study.as_ref().map(|study| &study.report).map_err(ToString::to_string);
        answered.push((name.clone(), report));
    }
    each::tell(output, &Compared::of(&answered), inputs)?;
    Ok(ExitCode::SUCCESS)
}

/// Whether Ctrl-C was pressed; pressed once more, it ends the program at once.
fn interrupted() -> Result<Arc<AtomicBool>, Failure> {
    let is_stopped = Arc::new(AtomicBool::new(false));
    flag::register_conditional_shutdown(SIGINT, INTERRUPTED, Arc::clone(&is_stopped))
        .and_then(|_| flag::register(SIGINT, Arc::clone(&is_stopped)))
        .map_err(Failure::analysis)?;
    Ok(is_stopped)
}

/// The files that were read.
fn inputs(args: &GapArgs) -> Vec<&Path> {
    let logs = args.logs.iter().chain(&args.held_out).chain(&args.columns);
    std::iter::once(&args.model).chain(logs).map(PathBuf::as_path).collect()
}

fn request(args: &GapArgs) -> Result<Request, Failure> {
    let held_out = match (&args.held_out[..], args.split) {
        ([], split) => HeldOutChoice::Split(split.unwrap_or(0.67)),
        (files, _) => HeldOutChoice::Logs(files.to_vec()),
    };
    let effects = args.effects.as_deref().map(|file| {
        let read = TextEffects::read(file).map_err(Failure::of_input)?;
        if read == TextEffects::default() {
            let expected = "there is no effect in it: expected a table for each, such as [brush]";
            return Err(Failure::input(file, expected));
        }
        let wrong = |error| Failure::of_input(format!("{}: {error}", file.display()));
        read.effects().map_err(wrong)
    });
    let effects = effects.transpose()?.unwrap_or_default();
    let disorder = if args.drop_disorder { Disorder::Drop } else { Disorder::Reject };
    let plain = Request::new(&args.model, &args.logs);
    Ok(Request {
        columns: given(args.columns.as_deref(), LogMap::read)?,
        held_out,
        effects,
        horizon: args.horizon,
        exclude: args.exclude.clone(),
        only: args.only.clone(),
        tolerances: args.tolerance.clone(),
        noise: args.noise.clone(),
        resample: ResampleChoice {
            sample_time: args.resample,
            longest_gap: args.longest_hole,
            disorder,
        },
        as_read: args.as_read,
        starts: args.starts,
        controller_sees: args.controller_sees,
        seed: args.seed,
        most: args.most.map_or(plain.most, |n| n as usize),
        calibrate: args.calibrate.map(|n| n as usize),
        budget: args.budget,
        thorough: args.thorough,
        limits: Limits {
            steps: if args.yes { u64::MAX } else { plain.limits.steps },
            ..plain.limits
        },
        ..plain
    })
}

/// What was asked of a simulator outside of this program.
fn work(counts: &Counts) -> String {
    let Counts { asked, made, repeated, steps, deaths, lost, inside, .. } = counts;
    let inside = figure(inside.as_secs_f64());
    format!(
        "Simulator: {asked} runs asked for (those of one step among them), {made} made and {repeated} made again, \
         {steps} steps, {inside} s inside; {deaths} deaths, {lost} runs lost"
    )
}
