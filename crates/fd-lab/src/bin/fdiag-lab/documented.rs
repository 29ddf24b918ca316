//! Every command of the help texts and of the documentation is one.

use clap::CommandFactory;
use fd_console::documented::check;

use super::args::Cli;

#[test]
fn every_command_that_is_shown_is_one() {
    Cli::command().debug_assert();
    let faults = check(&Cli::command(), 10);
    assert!(faults.is_empty(), "{faults:#?}");
}
