//! `fdiag completions` and `fdiag man`: the command line, told to shells and to `man`.

use std::{fs, path::PathBuf, process::ExitCode};

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::{args::Cli, failure::Failure, say::say};

/// After the options in the help text.
pub(crate) const COMPLETIONS_HELP: &str = "\
Examples:
  fdiag completions bash > ~/.local/share/bash-completion/completions/fdiag
  fdiag completions zsh > ~/.zfunc/_fdiag
  fdiag completions fish > ~/.config/fish/completions/fdiag.fish";

/// After the options in the help text.
pub(crate) const MAN_HELP: &str = "\
Example:
  fdiag man ~/.local/share/man/man1";

#[derive(Debug, Args)]
pub(crate) struct CompletionsArgs {
    /// The shell that is to complete commands and options
    #[arg(value_name = "SHELL", value_enum)]
    shell: Shell,
}

#[derive(Debug, Args)]
pub(crate) struct ManArgs {
    /// Directory for the pages, one for each command; made if it is not there
    #[arg(value_name = "DIR")]
    directory: PathBuf,
}

pub(crate) fn completions(args: &CompletionsArgs) -> Result<ExitCode, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "fdiag", &mut script);
    say(&String::from_utf8_lossy(&script))?;
    Ok(ExitCode::SUCCESS)
}

pub(crate) fn man(args: &ManArgs) -> Result<ExitCode, Failure> {
    let failed = |error| Failure::output(&args.directory, error);
    fs::create_dir_all(&args.directory).map_err(failed)?;
    clap_mangen::generate_to(Cli::command(), &args.directory).map_err(failed)?;
    Ok(ExitCode::SUCCESS)
}
