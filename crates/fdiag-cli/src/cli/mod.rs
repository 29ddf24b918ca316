//! The commands of `fdiag`.

mod args;
mod args_watch;
mod blind;
mod compare;
mod compensate;
mod engine;
mod failure;
mod gap;
mod log;
mod output;
mod pool;
mod progress;
mod provenance;
mod simulator;
mod structure;
mod toml_file;
mod watch;

use std::process::ExitCode;

use clap::Parser;

use self::args::{Cli, Command, EngineArgs};

/// Runs what the command line asks for and says how it went.
pub(crate) fn run() -> ExitCode {
    let result = match Cli::parse().command {
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
    };
    match result {
        Ok(code) => code,
        Err(failure) => {
            eprintln!("fdiag: {failure}");
            failure.code()
        }
    }
}
