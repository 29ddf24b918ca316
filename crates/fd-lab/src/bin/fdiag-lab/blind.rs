//! `fdiag-lab blind`: the blind test of the gap diagnosis.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::LazyLock,
};

use clap::{Args, Subcommand, ValueEnum, builder::PossibleValue};
use fd_core::Limits;
use fd_gap::diagnose::Settings;
use fd_lab::blind::{
    BlindError, CaseKind, Feature, Manner, Order, SealKey, Variant, make, run, score,
};
use fd_model::Record;
use fdiag::gap_study::automatic_settings;
use fdiag::sim::model::Model;

use fd_console::{
    failure::{ExitCode, Failure},
    output::{Output, OutputArgs},
    patience::{PatienceArgs, Plan},
    pool::pool,
    progress::Bar,
    say::{remark, say},
};

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
    #[command(flatten)]
    classes: ClassArgs,
    /// Samples of each log
    #[arg(long, value_name = "N", default_value_t = 1000)]
    samples: usize,
    /// Only look whether effects can be seen at all, not for rivals that cannot be told from them
    #[arg(long)]
    quick_oracle: bool,
    /// Begin also what will take very long, or much memory
    #[arg(long)]
    yes: bool,
    /// Number of threads; 0 takes all cores
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
}

/// Logs as people have them.
#[derive(Debug, Args)]
struct ClassArgs {
    /// Cases from a loop whose controller is not in the model
    #[arg(long = "loop", value_name = "N", default_value_t = 0)]
    looped: usize,
    /// Cases from such a loop without any effect
    #[arg(long, value_name = "N", default_value_t = 0)]
    loop_none: usize,
    /// Cases of unstable plants in such a loop
    #[arg(long, value_name = "N", default_value_t = 0)]
    unstable: usize,
    /// Cases of unstable plants without any effect
    #[arg(long, value_name = "N", default_value_t = 0)]
    unstable_none: usize,
    /// Cases of one run that is cut in two
    #[arg(long, value_name = "N", default_value_t = 0)]
    cut: usize,
    /// Cases of one run that is cut in two, without any effect
    #[arg(long, value_name = "N", default_value_t = 0)]
    cut_none: usize,
    /// Cases of which the logs begin in motion
    #[arg(long, value_name = "N", default_value_t = 0)]
    in_motion: usize,
    /// Cases of which the logs begin in motion, without any effect
    #[arg(long, value_name = "N", default_value_t = 0)]
    in_motion_none: usize,
    /// Cases with one large effect among three small ones
    #[arg(long, value_name = "N", default_value_t = 0)]
    dominant: usize,
    /// Cases with coarse steps and short ranges of the log
    #[arg(long, value_name = "N", default_value_t = 0)]
    coarse: usize,
    /// Such cases without any effect
    #[arg(long, value_name = "N", default_value_t = 0)]
    coarse_none: usize,
    /// Cases with a jittering clock, missing samples and lost rows
    #[arg(long, value_name = "N", default_value_t = 0)]
    patchy: usize,
    /// Such cases without any effect
    #[arg(long, value_name = "N", default_value_t = 0)]
    patchy_none: usize,
    /// Cases with a mistake in the reading of the log
    #[arg(long, value_name = "N", default_value_t = 0)]
    misread: usize,
    /// Cases with a parameter that walks at random
    #[arg(long, value_name = "N", default_value_t = 0)]
    wander: usize,
    /// Cases with an effect on a signal inside the model
    #[arg(long, value_name = "N", default_value_t = 0)]
    inside: usize,
}

impl ClassArgs {
    fn counts(&self) -> [(CaseKind, usize); 16] {
        [
            (CaseKind::Loop, self.looped),
            (CaseKind::LoopNone, self.loop_none),
            (CaseKind::Unstable, self.unstable),
            (CaseKind::UnstableNone, self.unstable_none),
            (CaseKind::Cut, self.cut),
            (CaseKind::CutNone, self.cut_none),
            (CaseKind::InMotion, self.in_motion),
            (CaseKind::InMotionNone, self.in_motion_none),
            (CaseKind::Dominant, self.dominant),
            (CaseKind::Coarse, self.coarse),
            (CaseKind::CoarseNone, self.coarse_none),
            (CaseKind::Patchy, self.patchy),
            (CaseKind::PatchyNone, self.patchy_none),
            (CaseKind::Misread, self.misread),
            (CaseKind::Wander, self.wander),
            (CaseKind::Inside, self.inside),
        ]
    }
}

/// In which form a case is diagnosed.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Form {
    /// As it was logged
    #[default]
    AsLogged,
    /// With the controller in the model, where there is one
    KnownController,
    /// From separate runs that begin at rest, where it was not
    FromRest,
    /// As it was logged, with the plant as a black box that only steps
    BlackBox,
    /// The same with few runs of the plant
    FewRuns,
    /// The same where nothing of the plant can be seen but its outputs, in single precision
    FewRunsOfOutputs,
    /// The same where the plant makes whole runs only
    FewWholeRuns,
}

impl Form {
    fn variant(self) -> Variant {
        match self {
            Self::AsLogged => Variant::AsLogged,
            Self::KnownController => Variant::KnownController,
            Self::FromRest => Variant::FromRest,
            Self::BlackBox => Variant::BlackBox,
            Self::FewRuns => Variant::FewRuns,
            Self::FewRunsOfOutputs => Variant::FewRunsOfOutputs,
            Self::FewWholeRuns => Variant::FewWholeRuns,
        }
    }
}

/// What can be left out of the method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Left(Feature);

impl ValueEnum for Left {
    fn value_variants<'a>() -> &'a [Self] {
        static EVERY: LazyLock<Vec<Left>> = LazyLock::new(|| Feature::EVERY.map(Left).into());
        &EVERY
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.0.name()).help(self.0.words()))
    }
}

/// How long simulations run without seeing the outputs.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Span {
    /// Through the whole log
    #[default]
    Free,
    /// As `fdiag gap` chooses by itself
    Auto,
}

#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// Directory that `fdiag-lab blind make` has made
    #[arg(value_name = "DIR")]
    directory: PathBuf,
    /// Leave out the simpler methods
    #[arg(long)]
    no_baselines: bool,
    /// In which form the cases are diagnosed; each has answers of its own
    #[arg(long, value_name = "FORM", value_enum, default_value_t)]
    form: Form,
    /// What the method is to do without, to see what it brings; these are answers of their own, too
    #[arg(long, value_name = "FEATURE", value_enum)]
    without: Option<Left>,
    /// How long simulations run without seeing the outputs
    #[arg(long, value_name = "HORIZON", value_enum, default_value_t)]
    horizon: Span,
    #[command(flatten)]
    patience: PatienceArgs,
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
    /// The form of which the answers are scored
    #[arg(long, value_name = "FORM", value_enum, default_value_t)]
    form: Form,
    /// Score the answers of the method without this
    #[arg(long, value_name = "FEATURE", value_enum)]
    without: Option<Left>,
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
    let mut counts = vec![
        (CaseKind::Single, args.single),
        (CaseKind::None, args.none),
        (CaseKind::Withheld, args.withheld),
        (CaseKind::Pair, args.pairs),
        (CaseKind::Mismatch, args.mismatch),
    ];
    counts.extend(args.classes.counts());
    let order =
        Order { seed: args.seed, counts, samples: args.samples, full_oracle: !args.quick_oracle };
    let truth = args.truth.clone().unwrap_or_else(|| beside(&args.out));
    let key = SealKey::random().map_err(refusal)?;
    let pool = pool(args.threads)?;
    let cost = pool.install(|| order.cost(&Limits::default())).map_err(refusal)?;
    let patience = PatienceArgs { yes: args.yes, ..PatienceArgs::default() };
    let cases: usize = order.counts.iter().map(|(_, count)| count).sum();
    let work = format!("{cases} cases of {} samples", order.samples);
    match patience.plan(cost.seconds, cost.bytes) {
        Plan::Short => {}
        Plan::Told(cost) => remark(&format!("{work}: {cost}")),
        Plan::Refused(cost) => {
            return Err(Failure::analysis(format!("{work}: {cost}; go on with --yes")));
        }
    }
    let progress = Bar::new("cases");
    let made =
        pool.install(|| make(&order, &args.out, &truth, &key, &progress)).map_err(refusal)?;
    progress.finish()?;
    let [out, truth] = [&args.out, &truth].map(|path| path.display());
    say(&format!("{} cases in {out}, their truth in {truth}\n", made.len()))?;
    Ok(ExitCode::SUCCESS)
}

fn run_cases(args: &RunArgs) -> Result<ExitCode, Failure> {
    let variant = args.form.variant();
    let progress = Bar::new("cases").within(&args.patience, 0.0);
    let settings = |model: &Model, logs: &[Record; 2]| match args.horizon {
        Span::Free => Ok(Settings::default()),
        Span::Auto => Ok(automatic_settings(model, logs)?),
    };
    let without = args.without.map(|left| left.0);
    let with_baselines = !args.no_baselines;
    let manner = Manner { variant, without, with_baselines, settings: &settings };
    let cases = match pool(args.threads)?.install(|| run(&args.directory, &manner, &progress)) {
        Err(BlindError::Stopped) => return Err(progress.stopped(&args.directory)),
        done => done.map_err(refusal)?,
    };
    progress.finish()?;
    say(&format!("{cases} cases are answered in {}\n", args.directory.display()))?;
    Ok(ExitCode::SUCCESS)
}

fn score_cases(args: &ScoreArgs) -> Result<ExitCode, Failure> {
    let output = Output::prepare(&args.output)?;
    let truth = args.truth.clone().unwrap_or_else(|| beside(&args.directory));
    let progress = Bar::new("cases");
    let without = args.without.map(|left| left.0);
    let score = pool(args.output.threads)?
        .install(|| score(&args.directory, &truth, args.form.variant(), without, &progress))
        .map_err(refusal)?;
    progress.finish()?;
    if let Some(file) = &args.markdown {
        fs::write(file, score.markdown()).map_err(|e| Failure::output(file, e))?;
    }
    let page = score.page().map_err(Failure::analysis)?;
    output.finish(&score.headline(), &score.tables(), page, &score, &[])?;
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
