//! The command line `fdiag-lab`: experiments and proofs, which no user of `fdiag` needs.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command-line tool")]

mod args;
mod blind;
mod compare;
#[cfg(test)]
mod documented;
mod engine;
mod rates;

use clap::{CommandFactory, Parser};
use fd_console::{
    failure::{ExitCode, Failure},
    say::{be_quiet, complain, say},
    shell,
};

use self::args::{Cli, Command};

fn main() -> ExitCode {
    let cli = Cli::parse();
    if cli.quiet {
        be_quiet();
    }
    match run(cli.command) {
        Ok(code) => code,
        Err(failure) => {
            complain(&format!("fdiag-lab: {failure}"));
            failure.code()
        }
    }
}

fn run(command: Option<Command>) -> Result<ExitCode, Failure> {
    match command {
        None => say(&Cli::command().render_help().to_string()).map(|()| ExitCode::SUCCESS),
        Some(Command::Engine(args)) => engine::run(&args),
        Some(Command::Compare(args)) => compare::run(&args),
        Some(Command::Rates(args)) => rates::run(&args),
        Some(Command::Blind { command }) => blind::run_command(&command),
        Some(Command::Completions(args)) => shell::completions(&args, Cli::command()),
        Some(Command::Man(args)) => shell::man(&args, Cli::command()),
    }
}
