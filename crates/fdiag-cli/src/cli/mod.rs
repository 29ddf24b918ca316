//! The commands of `fdiag`.

mod args;
mod args_watch;
mod calibrate;
mod compensate;
mod demo;
#[cfg(test)]
mod documented;
mod each;
mod gap;
mod given;
mod log;
mod numbers;
mod refusal;
mod simulator;
mod structure;
mod watch;

use std::ffi::OsString;

use clap::{CommandFactory, Parser};
use fd_console::{bounds, failure, output, pool, progress, say, shell};
use fdiag::NoPrograms;

use self::{
    args::{Cli, Command},
    bounds::{BoundsArgs, Ending},
    failure::{ExitCode, Failure},
    say::{be_quiet, complain, say},
};

/// The last line of `fdiag` alone.
const START: &str = "To start: `fdiag demo` shows both halves of the method in half a minute; \
                     `fdiag gap --help` has examples for a simulator and logs of your own.";

/// Runs what the command line asks for, the name of the program first, and says how it went.
///
/// ```
/// # use fd_console::failure::ExitCode;
/// // A wrong command line is code 2.
/// assert_eq!(fdiag_cli::run(["fdiag", "gap", "--modle", "cart.toml"]), ExitCode(2));
/// ```
pub fn run<T: Into<OsString> + Clone>(arguments: impl IntoIterator<Item = T>) -> ExitCode {
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(error) => {
            // Where nothing can be printed, there is nobody to tell.
            let _ = error.print();
            return ExitCode(u8::try_from(error.exit_code()).unwrap_or(2));
        }
    };
    if cli.quiet {
        be_quiet();
    }
    let runs_programs = cli.command.as_ref().is_some_and(Command::runs_programs);
    let _guard = (cli.no_programs || !runs_programs).then(NoPrograms::begin);
    let ending = cli.command.as_ref().map_or(Ending::AtOnce, Command::ending);
    let watched = cli.bounds.begin(ending);
    let result = watched.and_then(|_watched| asked(cli.command, cli.bounds));
    match result {
        Ok(code) => code,
        Err(failure) => {
            complain(&format!("fdiag: {failure}"));
            failure.code()
        }
    }
}

/// Does what is asked for.
fn asked(command: Option<Command>, bounds: BoundsArgs) -> Result<ExitCode, Failure> {
    match command {
        None => how_to_start(),
        Some(Command::Demo(args)) => demo::run(&args),
        Some(Command::Compensate(args)) => compensate::run(&args),
        Some(Command::Gap(args)) => gap::run(&args, bounds.time_limit),
        Some(Command::Calibrate(args)) => calibrate::run(&args),
        Some(Command::Log { command }) => log::run(&command),
        Some(Command::Structure(args)) => structure::run(&args),
        Some(Command::Simulator { command }) => simulator::run(&command),
        Some(Command::Watch(args)) => watch::run(&args),
        Some(Command::Completions(args)) => shell::completions(&args, Cli::command()),
        Some(Command::Man(args)) => shell::man(&args, Cli::command()),
    }
}

/// What `fdiag` says to somebody who asks for nothing.
fn how_to_start() -> Result<ExitCode, Failure> {
    say(&format!("{}\n{START}\n", Cli::command().render_help()))?;
    Ok(ExitCode::SUCCESS)
}
