//! What can be asked on the command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

/// Compares a plant with its model on line, learns the bias that modelling errors leave in the
/// residual, subtracts it, and so makes small faults visible (Patton & Chen, 1992).
///
/// Without a command it runs `fdiag engine`: the paper's experiment on a simulated jet engine.
#[derive(Debug, Parser)]
#[command(name = "fdiag", version, max_term_width = 100, after_help = AFTER_HELP)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

const AFTER_HELP: &str = "\
Exit codes:
  0  done
  1  done, and --fail-on-alarm was given and a log raised an alarm
  2  the command line is wrong
  3  an input file is missing or wrong; the message says where
  4  the data or the model do not allow what was asked; the message says why
  5  a result could not be written

Tables go to standard output, progress and errors to standard error. Progress is shown only on a
terminal. Results are the same for any number of threads.";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run the jet-engine benchmark: residual compensation with and without sensor faults
    ///
    /// Simulates perturbed engines, one per seed, with a 5th-order model of the nominal one. For
    /// each it learns the bias of the residual, freezes it, and finds the smallest T7 and P6
    /// sensor faults that are detected with and without compensation at the same false-alarm
    /// rate. Writes report.html, report.json and the pictures of the paper's figures 4 to 7.
    Engine(EngineArgs),
    /// Learn and remove the residual bias of your own model, then look for faults in later logs
    ///
    /// Reads a linear model (TOML) and logs of the real thing (CSV); docs/formats.md describes
    /// both. The healthy logs are for training and for the alarm threshold.
    Compensate(CompensateArgs),
    /// Test the gap diagnosis on cases whose cause it does not know
    ///
    /// `make` simulates plants with hidden effects and seals the truth, `run` diagnoses them without
    /// it, `score` opens the truth and counts. See docs/blind.md.
    Blind {
        #[command(subcommand)]
        command: super::blind::BlindCommand,
    },
}

#[derive(Debug, Default, Args)]
pub(crate) struct EngineArgs {
    /// Configuration file (TOML); see --print-config for all settings and their defaults
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// Number of perturbed engines
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) seeds: Option<u64>,
    /// First seed
    #[arg(long, value_name = "S")]
    pub(crate) first_seed: Option<u64>,
    /// Print the configuration that would run, and stop
    #[arg(long)]
    pub(crate) print_config: bool,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

#[derive(Debug, Args)]
pub(crate) struct CompensateArgs {
    /// Model file of the nominal plant (TOML)
    #[arg(long, value_name = "FILE")]
    pub(crate) model: PathBuf,
    /// Log of the real plant (CSV), several times for several; without --healthy the first one is
    /// the healthy log, the others are diagnosed
    #[arg(long = "log", value_name = "FILE", required_unless_present = "healthy")]
    pub(crate) logs: Vec<PathBuf>,
    /// Log of the healthy plant (CSV) to learn from, several times for several runs
    #[arg(long, value_name = "FILE")]
    pub(crate) healthy: Vec<PathBuf>,
    /// Column map of the logs (TOML); without it columns are found by channel name
    #[arg(long, value_name = "FILE")]
    pub(crate) columns: Option<PathBuf>,
    /// Choice of residual generator, bias model, detector and rule (TOML)
    #[arg(long, value_name = "FILE")]
    pub(crate) spec: Option<PathBuf>,
    /// Share of each healthy log, from its start, to learn the bias from; the alarm threshold is
    /// taken from the rest
    #[arg(long, value_name = "SHARE", default_value_t = 0.7, value_parser = share)]
    pub(crate) learn_share: f64,
    /// Print the spec that would run, and stop
    #[arg(long)]
    pub(crate) print_spec: bool,
    /// Exit with code 1 when a later log raises an alarm
    #[arg(long)]
    pub(crate) fail_on_alarm: bool,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

#[derive(Debug, Args)]
pub(crate) struct OutputArgs {
    /// Directory for the report; made if it is not there
    #[arg(long, value_name = "DIR", default_value = "fdiag-report")]
    pub(crate) out: PathBuf,
    /// Print the result as JSON instead of a table
    #[arg(long)]
    pub(crate) json: bool,
    /// Number of threads; 0 takes all cores
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) threads: usize,
}

impl Default for OutputArgs {
    fn default() -> Self {
        Self { out: PathBuf::from("fdiag-report"), json: false, threads: 0 }
    }
}

/// A part of a whole that leaves something of it.
fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if 0.0 < share && share < 1.0 => Ok(share),
        Ok(_) => Err("expected a number between 0 and 1, both excluded".to_owned()),
        Err(error) => Err(format!("expected a number between 0 and 1: {error}")),
    }
}
