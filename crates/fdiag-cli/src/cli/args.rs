//! What can be asked on the command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use fdiag::gap_study::{Budget, ControllerSees, HorizonChoice, Named, StartsChoice};

use super::{
    bounds::{BoundsArgs, Ending},
    numbers::{positive, share},
    output::OutputArgs,
};

/// Compares a plant with its model on line, learns the bias that modelling errors leave in the
/// residual, subtracts it, and so makes small faults visible (Patton & Chen, 1992).
#[derive(Debug, Parser)]
#[command(name = "fdiag", version, max_term_width = 100, after_help = AFTER_HELP)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub command: Option<Command>,
    /// Say nothing on standard error but what is wrong
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Start no program and load no library that a model file names (kind = "process" or "fmu")
    #[arg(long, global = true)]
    pub no_programs: bool,
    #[command(flatten)]
    pub bounds: BoundsArgs,
}

impl Command {
    /// Whether the command is one that executes what a model file of kind `process` or `fmu` names. The others never do.
    pub(crate) fn runs_programs(&self) -> bool {
        match self {
            Self::Gap(_) | Self::Calibrate(_) | Self::Simulator { .. } => true,
            Self::Demo(_)
            | Self::Compensate(_)
            | Self::Watch(_)
            | Self::Structure(_)
            | Self::Log { .. }
            | Self::Completions(_)
            | Self::Man(_) => false,
        }
    }

    /// How the command ends when its time is over.
    pub(crate) fn ending(&self) -> Ending {
        match self {
            Self::Gap(_) | Self::Watch(_) => Ending::InOrder,
            _ => Ending::AtOnce,
        }
    }
}

const AFTER_HELP: &str = "\
Which command:
  fdiag demo        shows both halves of the method on one page, in half a minute
  fdiag gap         says what the model does not know: where, which effect, how far it matters
  fdiag compensate  learns what modelling errors do, without a name for them, to see small faults
  fdiag watch       does that on line, next to the plant, for months
  fdiag log info    says what is in a log, and what is doubtful about it
  fdiag structure   says which faults a model can reveal at all, and what more sensors would add
  fdiag simulator   says whether a simulator of your own is fit for fdiag gap

Exit codes:
  0  done
  1  done, and --fail-on-alarm was given and a log raised an alarm, or a simulator is broken
  2  the command line is wrong
  3  an input file is missing or wrong; the message says where
  4  the data or the model do not allow what was asked; the message says why
  5  a result could not be written
  6  --time-limit or --memory-limit was reached before there was a result

Tables go to standard output, progress and errors to standard error. Progress is shown only on a
terminal. Results are the same for any number of threads.";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Show both halves of the method in half a minute: a bias learned, and a cause named
    ///
    /// Lays model files and logs of a jet engine and of a cart into --out, learns what the model of the engine lacks
    /// until a drifting sensor becomes visible, and names what the simulator of the cart lacks. Writes report.html,
    /// report.json, pictures (SVG), and the reports of both halves; the page shows the commands that repeat them.
    #[command(after_help = super::demo::DEMO_HELP)]
    Demo(super::demo::DemoArgs),
    /// Learn and remove the residual bias of your own model, then look for faults in later logs
    ///
    /// Reads a linear model (TOML) and logs of the real thing (CSV); docs/formats.md describes
    /// both. The healthy logs are for training and for the alarm threshold.
    Compensate(CompensateArgs),
    /// Watch plants on line: samples in, alarms out, a state that survives a kill
    ///
    /// Reads samples as they come (NDJSON or CSV on standard input, or a file that grows), compares them with a
    /// linear model as `fdiag compensate` does, and writes alarms and events as NDJSON to standard output. With
    /// --state an alarm is on the disk before it is printed, and a monitor that was killed resumes where it was.
    /// docs/watch.md describes input, output and state.
    #[command(after_help = super::args_watch::WATCH_HELP)]
    Watch(Box<super::args_watch::WatchArgs>),
    /// Say which unmodelled effect separates a simulator from logs of the real system
    ///
    /// Reads a model with equations as text (docs/model-equations.md), a linear one, a simulator of your
    /// own (kind = "process" or "fmu", docs/process-protocol.md, docs/fmu.md) or the jet engine
    /// (kind = "engine17", docs/gap.md), and logs of the real thing (CSV, docs/formats.md). Refits the parameters within their tolerances, tries every known
    /// effect at every place of the model, and says where the gap lies, which effect causes it and
    /// how sure that is, how far the gap shrinks on data that no fit has seen, and what experiment
    /// would settle what this log cannot. Writes report.html, report.json and patched.toml, the
    /// simulator with the cause in it. How to read the answer: docs/gap.md.
    #[command(after_help = GAP_HELP)]
    Gap(Box<GapArgs>),
    /// Fit all uncertain parameters of a simulator to logs: values, errors, and what the logs cannot tell
    ///
    /// Takes simulators and logs as `fdiag gap` does, and fits every parameter that has a tolerance to all logs at once.
    /// Says of each its value and standard error, which are fixed only in combination with others, which are at the edge
    /// of what is allowed, which these logs do not move; and what is left then. docs/gap.md, "Calibration".
    #[command(after_help = super::calibrate::CALIBRATE_HELP)]
    Calibrate(super::calibrate::CalibrateArgs),
    /// Say which faults a model can reveal at all, by which tests, and what more sensors would add
    ///
    /// Looks only at which quantity is in which equation of a model file (docs/model-equations.md, docs/formats.md),
    /// before any number and any log: which faults can be detected and isolated, also by tests that only
    /// integrate or only differentiate, which equations make the tests, which few residuals isolate as much as all
    /// of them, and which sensors would have to be added to isolate everything. Writes report.html, report.json, structure.svg
    /// and isolability.svg.
    #[command(after_help = super::structure::STRUCTURE_HELP)]
    Structure(Box<super::structure::StructureArgs>),
    /// Check a simulator of your own, or serve one of a model file
    ///
    /// `fdiag gap` takes any program that speaks a small protocol on its standard input and output
    /// (docs/process-protocol.md). `check` runs it, and says what it is, what it can do, what is wrong
    /// with it, and what a diagnosis will cost; `serve` is such a program for a model of equations.
    Simulator {
        #[command(subcommand)]
        command: super::simulator::SimulatorCommand,
    },
    /// Say what is in a log file
    Log {
        #[command(subcommand)]
        command: super::log::LogCommand,
    },
    /// Print a script that completes commands and options in a shell
    #[command(after_help = COMPLETIONS_HELP)]
    Completions(super::shell::CompletionsArgs),
    /// Write this help as pages of `man`
    #[command(after_help = MAN_HELP)]
    Man(super::shell::ManArgs),
}

const COMPLETIONS_HELP: &str = "\
Examples:
  fdiag completions bash > ~/.local/share/bash-completion/completions/fdiag
  fdiag completions zsh > ~/.zfunc/_fdiag
  fdiag completions fish > ~/.config/fish/completions/fdiag.fish";

const MAN_HELP: &str = "\
Example:
  fdiag man ~/.local/share/man/man1";

const GAP_HELP: &str = "\
Examples:
  fdiag gap --model cart.toml --log monday.csv
  fdiag gap --model cart.toml --log monday.csv --log tuesday.csv --held-out friday.csv
  fdiag gap --model cart.toml --log monday.csv --log tuesday.csv --log friday.csv --each
  fdiag gap --model cart.toml --log monday.csv --tolerance m=0.01 --noise speed=0.005
  fdiag gap --model cart.toml --log monday.csv --exclude input-delay@force --calibrate 5
  fdiag gap --model examples/process/cart.toml --log examples/gap/quick-start/monday.csv --budget 300runs
  fdiag gap --model examples/gap/engine/engine.toml --log examples/gap/engine/valve.csv";

#[derive(Debug, Args)]
pub(crate) struct CompensateArgs {
    /// Model file of the nominal plant (TOML)
    #[arg(long, value_name = "FILE")]
    pub model: PathBuf,
    /// Logs of the real plant (CSV), one or several; may be repeated; without --healthy the first one is
    /// the healthy log, the others are diagnosed
    #[arg(long = "log", value_name = "FILE", num_args = 1.., required_unless_present_any = ["healthy", "print_spec"])]
    pub logs: Vec<PathBuf>,
    /// Logs of the healthy plant (CSV) to learn from, one or several; may be repeated
    #[arg(long, value_name = "FILE", num_args = 1..)]
    pub healthy: Vec<PathBuf>,
    /// Column map of the logs (TOML); without it columns are found by channel name
    #[arg(long, value_name = "FILE")]
    pub columns: Option<PathBuf>,
    /// Choice of residual generator, bias model, detector and rule (TOML)
    #[arg(long, value_name = "FILE")]
    pub spec: Option<PathBuf>,
    /// Share of each healthy log, from its start, to learn the bias from; the alarm threshold is
    /// taken from the rest
    #[arg(long, value_name = "SHARE", default_value_t = 0.7, value_parser = share)]
    pub learn_share: f64,
    /// Print the spec that would run on the model, that of --spec or the defaults, and stop; needs no log
    #[arg(long)]
    pub print_spec: bool,
    /// Exit with code 1 when a later log raises an alarm
    #[arg(long)]
    pub fail_on_alarm: bool,
    #[command(flatten)]
    pub output: OutputArgs,
}

#[derive(Debug, Args)]
#[expect(clippy::struct_excessive_bools, reason = "each is a switch of its own")]
pub(crate) struct GapArgs {
    /// Model file of the simulator (TOML)
    #[arg(long, value_name = "FILE")]
    pub model: PathBuf,
    /// Logs of the real system (CSV), one or several; may be repeated
    #[arg(long = "log", value_name = "FILE", num_args = 1.., required_unless_present = "print_model")]
    pub logs: Vec<PathBuf>,
    /// Diagnose every log by itself, and say which causes and strengths agree
    #[arg(long)]
    pub each: bool,
    /// Column map of the logs (TOML); channels that it does not name are found by name
    #[arg(long, value_name = "FILE")]
    pub columns: Option<PathBuf>,
    /// Logs that no fit sees, to measure how far the gap shrinks, one or several; may be repeated
    #[arg(long, value_name = "FILE", num_args = 1.., conflicts_with = "split")]
    pub held_out: Vec<PathBuf>,
    /// Share of each log that is fitted to; its end is held out [default: 0.67 without --held-out]
    #[arg(long, value_name = "SHARE", value_parser = share)]
    pub split: Option<f64>,
    /// How long simulations run without seeing the outputs: `free` through the whole log, a number
    /// of seconds, or `auto`: free, unless the model runs away from its initial state
    #[arg(long, value_name = "free|auto|SECONDS", default_value = "auto")]
    pub horizon: HorizonChoice,
    /// Effects of your own that are tried as well (TOML, see docs/gap.md)
    #[arg(long, value_name = "FILE")]
    pub effects: Option<PathBuf>,
    /// Effect that is not tried: a label or a mechanism, also at one place (input-delay@u); several times
    #[arg(long, value_name = "EFFECT[@PLACE]")]
    pub exclude: Vec<String>,
    /// Effect that is tried, no others; named as for --exclude
    #[arg(long, value_name = "EFFECT[@PLACE]")]
    pub only: Vec<String>,
    /// How well a parameter is known, relative to its value, instead of what the model says;
    /// 0 for exactly
    #[arg(long, value_name = "NAME=SHARE")]
    pub tolerance: Vec<Named>,
    /// Standard deviation of the noise of an output, in its unit, instead of what the model says
    #[arg(long, value_name = "OUTPUT=SIGMA")]
    pub noise: Vec<Named>,
    /// Time between samples, in seconds, to which logs are resampled; without it the median of the
    /// first log
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub resample: Option<f64>,
    /// Longest hole of a log that is bridged, in seconds; without it five samples
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub longest_hole: Option<f64>,
    /// Drop rows whose time is not later than that of the row before, instead of refusing
    /// the log
    #[arg(long)]
    pub drop_disorder: bool,
    /// Take the log as it is read, without looking for wrong signs, units, columns and clocks
    #[arg(long)]
    pub as_read: bool,
    /// Where the logs begin: `stated` (where the model says), `free` (anywhere), or `either`, whichever explains them
    /// better
    #[arg(long, value_name = "WHERE", default_value = "either")]
    pub starts: StartsChoice,
    /// What a controller in the model acts on: `logged` (what was measured, noise included), `simulated` (a loop that is
    /// closed in the simulator), or `either`, whichever leaves less without any effect
    #[arg(long, value_name = "WHAT", default_value = "either")]
    pub controller_sees: ControllerSees,
    /// Also diagnose simulated logs of known cause, N of each, to see what such logs can tell
    #[arg(long, value_name = "N", num_args = 0..=1, default_missing_value = "5",
          value_parser = clap::value_parser!(u32).range(1..))]
    pub calibrate: Option<u32>,
    /// Most causes that are sought one after another where one does not explain the logs; 1 for no
    /// more. Without it the search goes on while held-out forecasts improve (8 at most)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub most: Option<u32>,
    /// What a diagnosis of a simulator of your own may cost, as time in it (`10min`, `90s`, `2h`) or as
    /// runs through the logs (`300runs`); what is left out for it is reported
    #[arg(long, value_name = "COST")]
    pub budget: Option<Budget>,
    /// Search a simulator of your own with thousands of runs, as equations are, instead of with few
    #[arg(long)]
    pub thorough: bool,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Begin also what will take very long, or much memory
    #[arg(long)]
    pub yes: bool,
    /// Print the model that would be diagnosed, with all its places for effects, and stop
    #[arg(long)]
    pub print_model: bool,
    #[command(flatten)]
    pub output: OutputArgs,
}
