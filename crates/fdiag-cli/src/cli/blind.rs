//! `fdiag blind`: the blind test of the gap diagnosis.

use std::{
    fs,
    path::{Path, PathBuf},
    process::ExitCode,
};

use clap::{Args, Subcommand};
use fd_lab::blind::{BlindError, CaseKind, Order, SealKey, make, progress, run, score};

use super::{args::OutputArgs, failure::Failure, output::Output, pool::pool, progress::bar};

#[derive(Debug, Subcommand)]
pub(crate) enum BlindCommand {
    /// Make cases, and seal what is true of them
    Make(MakeArgs),
    /// Diagnose all cases that have no answer yet
    Run(RunArgs),
    /// Open the truth and count what was right
    Score(ScoreArgs),
}

#[derive(Debug, Args)]
pub(crate) struct MakeArgs {
    /// Directory for the cases; must be new
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Directory for the truth; must be new, and lie apart [default: the one of the cases with
    /// `-truth` added]
    #[arg(long, value_name = "DIR")]
    truth: Option<PathBuf>,
    /// Seed of everything but the secret of the seal; 1 to 999 are for development
    #[arg(long, value_name = "S")]
    seed: u64,
    /// Cases with one effect
    #[arg(long, value_name = "N", default_value_t = 0)]
    single: usize,
    /// Cases without any effect, every other one with coloured noise
    #[arg(long, value_name = "N", default_value_t = 0)]
    none: usize,
    /// Cases with an effect of a class that the library does not have
    #[arg(long, value_name = "N", default_value_t = 0)]
    withheld: usize,
    /// Cases with two effects
    #[arg(long, value_name = "N", default_value_t = 0)]
    pairs: usize,
    /// Cases with an effect whose law the library does not have
    #[arg(long, value_name = "N", default_value_t = 0)]
    mismatch: usize,
    /// Samples of each log
    #[arg(long, value_name = "N", default_value_t = 1000)]
    samples: usize,
    /// Only look whether effects can be seen at all, not for rivals that cannot be told from them
    #[arg(long)]
    quick_oracle: bool,
    /// Number of threads; 0 takes all cores
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
}

#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// Directory that `fdiag blind make` has made
    #[arg(value_name = "DIR")]
    directory: PathBuf,
    /// Leave out the simpler methods
    #[arg(long)]
    no_baselines: bool,
    /// Number of threads; 0 takes all cores
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
}

#[derive(Debug, Args)]
pub(crate) struct ScoreArgs {
    /// Directory of cases and answers
    #[arg(value_name = "DIR")]
    directory: PathBuf,
    /// Directory of the truth [default: the one of the cases with `-truth` added]
    #[arg(long, value_name = "DIR")]
    truth: Option<PathBuf>,
    /// Write the tables as Markdown, too
    #[arg(long, value_name = "FILE")]
    markdown: Option<PathBuf>,
    #[command(flatten)]
    output: OutputArgs,
}

pub(crate) fn run_command(command: &BlindCommand) -> Result<ExitCode, Failure> {
    match command {
        BlindCommand::Make(args) => make_cases(args),
        BlindCommand::Run(args) => run_cases(args),
        BlindCommand::Score(args) => score_cases(args),
    }
}

fn make_cases(args: &MakeArgs) -> Result<ExitCode, Failure> {
    let counts = vec![
        (CaseKind::Single, args.single),
        (CaseKind::None, args.none),
        (CaseKind::Withheld, args.withheld),
        (CaseKind::Pair, args.pairs),
        (CaseKind::Mismatch, args.mismatch),
    ];
    let total: usize = counts.iter().map(|(_, n)| n).sum();
    let order =
        Order { seed: args.seed, counts, samples: args.samples, full_oracle: !args.quick_oracle };
    let truth = args.truth.clone().unwrap_or_else(|| beside(&args.out));
    let key = SealKey::random().map_err(refusal)?;
    let progress = bar(total as u64, "cases");
    let made = pool(args.threads)?
        .install(|| make(&order, &args.out, &truth, &key, || progress.inc(1)))
        .map_err(refusal)?;
    progress.finish_and_clear();
    println!("{} cases in {}, their truth in {}", made.len(), args.out.display(), truth.display());
    Ok(ExitCode::SUCCESS)
}

fn run_cases(args: &RunArgs) -> Result<ExitCode, Failure> {
    let before = progress(&args.directory).map_err(refusal)?;
    let bar = bar(before.cases as u64, "cases");
    bar.inc(before.answered as u64);
    pool(args.threads)?
        .install(|| run(&args.directory, !args.no_baselines, || bar.inc(1)))
        .map_err(refusal)?;
    bar.finish_and_clear();
    println!("{} cases are answered in {}", before.cases, args.directory.display());
    Ok(ExitCode::SUCCESS)
}

fn score_cases(args: &ScoreArgs) -> Result<ExitCode, Failure> {
    let output = Output::prepare(&args.output)?;
    let truth = args.truth.clone().unwrap_or_else(|| beside(&args.directory));
    let before = progress(&args.directory).map_err(refusal)?;
    let bar = bar(before.cases as u64, "cases");
    let score = pool(args.output.threads)?
        .install(|| score(&args.directory, &truth, || bar.inc(1)))
        .map_err(refusal)?;
    bar.finish_and_clear();
    if let Some(file) = &args.markdown {
        fs::write(file, score.markdown()).map_err(|e| Failure::output(file, e))?;
    }
    let json = serde_json::to_string_pretty(&score).map_err(Failure::analysis)?;
    output.write("score.json", &json)?;
    let page = score.page().map_err(Failure::analysis)?;
    output.finish(&score.headline(), &score.tables(), &page, &score)?;
    Ok(ExitCode::SUCCESS)
}

/// Where the truth of cases is unless somebody says otherwise.
fn beside(cases: &Path) -> PathBuf {
    let mut name = cases.to_owned().into_os_string();
    name.push("-truth");
    PathBuf::from(name)
}

/// A file is the fault of whoever named it, everything else of what was asked for.
fn refusal(error: BlindError) -> Failure {
    match &error {
        BlindError::File { .. } | BlindError::Content { .. } | BlindError::Journal(_) => {
            Failure::of_input(error)
        }
        _ => Failure::analysis(error),
    }
}
