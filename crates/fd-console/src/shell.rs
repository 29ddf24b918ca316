//! The command line, told to shells and to `man`.

use crate::failure::ExitCode;
use std::{fs, path::PathBuf};

use clap::{Args, Command};
use clap_complete::Shell;

use crate::{failure::Failure, say::say};

/// The shell that is told.
#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// The shell that is to complete commands and options
    #[arg(value_name = "SHELL", value_enum)]
    shell: Shell,
}

/// Where the pages go.
#[derive(Debug, Args)]
pub struct ManArgs {
    /// Directory for the pages, one for each command; made if it is not there
    #[arg(value_name = "DIR")]
    directory: PathBuf,
}

/// Prints the script by which a shell completes the commands of `program`.
///
/// # Errors
///
/// When standard output takes nothing.
pub fn completions(args: &CompletionsArgs, mut program: Command) -> Result<ExitCode, Failure> {
    let mut script = Vec::new();
    let name = program.get_name().to_owned();
    clap_complete::generate(args.shell, &mut program, name, &mut script);
    say(&String::from_utf8_lossy(&script))?;
    Ok(ExitCode::SUCCESS)
}

/// Writes the pages of `program`, one for each command.
///
/// # Errors
///
/// When a page cannot be written.
pub fn man(args: &ManArgs, program: Command) -> Result<ExitCode, Failure> {
    let failed = |error| Failure::output(&args.directory, error);
    fs::create_dir_all(&args.directory).map_err(failed)?;
    clap_mangen::generate_to(program, &args.directory).map_err(failed)?;
    Ok(ExitCode::SUCCESS)
}
