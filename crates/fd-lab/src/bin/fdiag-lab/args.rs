//! What can be asked of the laboratory.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use fd_console::{output::OutputArgs, patience::PatienceArgs, shell};

/// Experiments with fdiag: what compensation gains on a jet engine, which method wins where, how often a gap diagnosis
/// is right.
#[derive(Debug, Parser)]
#[command(name = "fdiag-lab", version, max_term_width = 100, after_help = AFTER_HELP)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub command: Option<Command>,
    /// Say nothing on standard error but what is wrong
    #[arg(long, short, global = true)]
    pub quiet: bool,
}

const AFTER_HELP: &str = "\
Which command:
  fdiag-lab engine   shows on simulated jet engines what compensation gains
  fdiag-lab compare  says which residual, compensation and detector find the smallest faults there
  fdiag-lab rates    says whether healthy runs alarm as often as was stated
  fdiag-lab blind    says how often the gap diagnosis names the right cause

Exit codes are those of fdiag. Results are the same for any number of threads.";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run the jet-engine benchmark: residual compensation with and without sensor faults
    ///
    /// Simulates perturbed engines, one per seed, with a 5th-order model of the nominal one. For
    /// each it learns the bias of the residual, freezes it, and finds the smallest T7 and P6
    /// sensor faults that are detected with and without compensation at the same false-alarm
    /// rate. Writes report.html, report.json and the pictures of the paper's figures 4 to 7.
    Engine(EngineArgs),
    /// Compare every residual generator, bias model and detector on the same engines
    ///
    /// Brings all of them to the same rate of false alarms on engines of their own, then counts on
    /// other engines which sensor and component faults they find, how soon, and whether they name the
    /// right sensor. Writes report.html, report.md and report.json. A run that was killed continues where it
    /// stopped when it is started again with the same settings and directory. docs/compare.md says
    /// which method to choose when.
    Compare(CompareArgs),
    /// Count how often healthy runs alarm where a rate was stated
    ///
    /// Trains on healthy logs of plants of one's own (docs/compare.md), as a user does, and counts the fresh healthy runs
    /// in which each detector alarms that states 5 % of the runs, beginning with a fitted bias and in training.
    Rates(RatesArgs),
    /// Test the gap diagnosis on cases whose cause it does not know
    ///
    /// `make` simulates plants with hidden effects and seals the truth, `run` diagnoses them without
    /// it, `score` opens the truth and counts. See docs/blind.md.
    Blind {
        #[command(subcommand)]
        command: super::blind::BlindCommand,
    },
    /// Print a script that completes commands and options in a shell
    Completions(shell::CompletionsArgs),
    /// Write this help as pages of `man`
    Man(shell::ManArgs),
}

#[derive(Debug, Args)]
pub(crate) struct EngineArgs {
    /// Configuration file (TOML); see --print-config for all settings and their defaults
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Number of perturbed engines
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub seeds: Option<u64>,
    /// First seed
    #[arg(long, value_name = "S")]
    pub first_seed: Option<u64>,
    /// Print the configuration that would run, and stop
    #[arg(long)]
    pub print_config: bool,
    /// Write model, spec and logs of the first seed to this directory, as `fdiag compensate` takes them, and stop
    #[arg(long, value_name = "DIR")]
    pub write_files: Option<PathBuf>,
    #[command(flatten)]
    pub patience: PatienceArgs,
    #[command(flatten)]
    pub output: OutputArgs,
}

#[derive(Debug, Args)]
pub(crate) struct CompareArgs {
    /// Configuration file (TOML); see --print-config for all settings and their defaults
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Number of engines that set the thresholds, and of those that the results are taken from
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub seeds: Option<u64>,
    /// First seed
    #[arg(long, value_name = "S")]
    pub first_seed: Option<u64>,
    /// Only this scenario of the configuration; may be repeated
    #[arg(long, value_name = "NAME")]
    pub scenario: Vec<String>,
    /// Start over, even if the directory holds the beginning of a comparison
    #[arg(long)]
    pub restart: bool,
    /// Print the configuration that would run, and stop
    #[arg(long)]
    pub print_config: bool,
    #[command(flatten)]
    pub patience: PatienceArgs,
    #[command(flatten)]
    pub output: OutputArgs,
}

#[derive(Debug, Args)]
pub(crate) struct RatesArgs {
    /// Configuration of a comparison with a plant of one's own (TOML); may be repeated
    #[arg(long, value_name = "FILE", required = true)]
    pub config: Vec<PathBuf>,
    /// Number of plants
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..))]
    pub seeds: u64,
    /// First seed
    #[arg(long, value_name = "S", default_value_t = 9001)]
    pub first_seed: u64,
    /// Healthy logs of each plant
    #[arg(long, value_name = "N", default_value_t = 20)]
    pub healthy: usize,
    /// Fresh healthy runs of each plant
    #[arg(long, value_name = "N", default_value_t = 30)]
    pub fresh: usize,
    /// Settling time in seconds; without it what the model needs
    #[arg(long, value_name = "SECONDS")]
    pub settle: Option<f64>,
    /// Relative change of the parameters at which learning on line ends [default: 0.001]
    #[arg(long, value_name = "SHARE")]
    pub tolerance: Option<f64>,
}
