//! The commands of `fdiag`.

mod args;
mod args_watch;
mod blind;
mod compare;
mod compensate;
#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]
mod documented;
mod engine;
mod failure;
mod gap;
mod log;
mod output;
mod patience;
mod pool;
mod progress;
mod provenance;
mod say;
mod shell;
mod simulator;
mod structure;
mod toml_file;
mod watch;

use std::process::ExitCode;

use clap::{CommandFactory, Parser};

use self::{
    args::{Cli, Command},
    failure::Failure,
    say::{be_quiet, complain, say},
};

/// The last line of `fdiag` alone.
const START: &str = "To start: `fdiag engine` repeats the paper's experiment (a minute or two); \
                     `fdiag gap --help` has examples for a simulator and logs of your own.";

/// Runs what the command line asks for and says how it went.
pub(crate) fn run() -> ExitCode {
    let cli = Cli::parse();
    if cli.quiet {
        be_quiet();
    }
    let result = match cli.command {
        None => how_to_start(),
        Some(Command::Engine(args)) => engine::run(&args),
        Some(Command::Compare(args)) => compare::run(&args),
        Some(Command::Compensate(args)) => compensate::run(&args),
        Some(Command::Gap(args)) => gap::run(&args),
        Some(Command::Log { command }) => log::run(&command),
        Some(Command::Structure(args)) => structure::run(&args),
        Some(Command::Simulator { command }) => simulator::run(&command),
        Some(Command::Watch(args)) => watch::run(&args),
        Some(Command::Blind { command }) => blind::run_command(&command),
        Some(Command::Completions(args)) => shell::completions(&args),
        Some(Command::Man(args)) => shell::man(&args),
    };
    match result {
        Ok(code) => code,
        Err(failure) => {
            complain(&format!("fdiag: {failure}"));
            failure.code()
        }
    }
}

/// What `fdiag` says to somebody who asks for nothing.
fn how_to_start() -> Result<ExitCode, Failure> {
    say(&format!("{}\n{START}\n", Cli::command().render_help()))?;
    Ok(ExitCode::SUCCESS)
}
