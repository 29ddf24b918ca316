//! Every command of the help texts, of README.md and of the documentation is one.

use clap::{Command, CommandFactory, Parser};

use super::args::Cli;

#[path = "../../tests/commands/documented.rs"]
mod shown;

use shown::{Shown, of_documents, of_help};

/// The words that the program would be given.
fn words(shown: &Shown) -> Vec<String> {
    let ours = shown.line.rsplit_once("| ").map_or(&*shown.line, |(_, ours)| ours);
    let mut words = vec![String::new()];
    let mut is_quoted = false;
    for character in ours.chars() {
        match character {
            '\'' => is_quoted = !is_quoted,
            ' ' if !is_quoted => words.push(String::new()),
            character => words.last_mut().unwrap().push(character),
        }
    }
    words.retain(|word| !word.is_empty());
    // What a shell keeps for itself.
    let end = words.iter().position(|word| word == ">" || word == "<");
    words.truncate(end.unwrap_or(words.len()));
    words
}

/// Help texts of a command and of those below it.
fn of_helps(command: &Command, path: &str, all: &mut Vec<Shown>) {
    if let Some(help) = command.get_after_help() {
        all.extend(of_help(path, &format!("\n{help}")));
    }
    for below in command.get_subcommands() {
        of_helps(below, format!("{path} {}", below.get_name()).trim(), all);
    }
}

#[test]
fn the_command_line_is_in_order() {
    Cli::command().debug_assert();
}

#[test]
fn every_command_that_is_shown_is_one() {
    let mut all = of_documents();
    // A loop of a shell runs over all of them.
    for shown in &mut all {
        shown.line = shown.line.replace("$form", "few-runs");
    }
    assert!(20 < all.len(), "{}", all.len());
    let mut helps = Vec::new();
    of_helps(&Cli::command(), "", &mut helps);
    assert!(20 < helps.len(), "{helps:?}");
    all.extend(helps);
    for shown in all {
        if let Err(error) = Cli::try_parse_from(words(&shown)) {
            panic!("{}: `{}`: {error}", shown.place, shown.line);
        }
    }
}

/// What the test above would not let pass.
#[test]
fn a_misspelled_option_is_found() {
    for line in [
        "fdiag gap --model a.toml --log b.csv --hold-out c.csv",
        "x | fdiag watsch",
        "fdiag engine --seeds",
    ] {
        let shown = Shown { place: String::new(), line: line.to_owned() };
        assert!(Cli::try_parse_from(words(&shown)).is_err(), "{line}");
    }
}
