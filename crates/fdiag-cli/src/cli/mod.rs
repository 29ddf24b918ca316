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

use clap::Parser;

use self::{
    args::{Cli, Command, EngineArgs},
    say::{be_quiet, complain},
};

/// Runs what the command line asks for and says how it went.
pub(crate) fn run() -> ExitCode {
    let cli = Cli::parse();
    if cli.quiet {
        be_quiet();
    }
    let result = match cli.command {
        None => engine::run(&EngineArgs::default()),
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
