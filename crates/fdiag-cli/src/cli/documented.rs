//! Every command of the help texts, of README.md and of the documentation is one.

use clap::CommandFactory;
use fd_console::documented::{check, parses};

use super::args::Cli;

#[test]
fn every_command_that_is_shown_is_one() {
    Cli::command().debug_assert();
    let faults = check(&Cli::command(), 30);
    assert!(faults.is_empty(), "{faults:#?}");
}

/// What the test above would not let pass.
#[test]
fn a_misspelled_option_is_found() {
    for line in [
        "fdiag gap --model a.toml --log b.csv --hold-out c.csv",
        "x | fdiag watsch",
        "fdiag compensate --model",
    ] {
        assert!(parses(&Cli::command(), line).is_err(), "{line}");
    }
}
