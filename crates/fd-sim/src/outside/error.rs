//! Why a simulator outside of this program cannot be used.

use thiserror::Error;

/// A simulator outside of this program cannot be used, or was lost in the middle of its work.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum OutsideError {
    /// The model file cannot be read, is no TOML, or has wrong, unknown or missing keys.
    #[error("{file}: {message}")]
    Syntax {
        /// The file.
        file: String,
        /// What is wrong and where.
        message: String,
    },
    /// A value makes no sense, or is missing.
    #[error("{place}: {key}: expected {expected}, found {found}")]
    Value {
        /// The file, or whose hello.
        place: String,
        /// The entry.
        key: String,
        /// What would make sense.
        expected: String,
        /// The value.
        found: String,
    },
    /// The program cannot be started.
    #[error("`{command}` cannot be started: {message}")]
    Start {
        /// The command.
        command: String,
        /// What the operating system says.
        message: String,
    },
    /// It would be executed, and that was forbidden.
    #[error(
        "{place}: {what} would be executed, and programs are forbidden here; where you trust it, run the command \
         without `--no-programs` (in a program of your own: without `forbid_programs`)"
    )]
    Forbidden {
        /// The file that names it, or where it would run.
        place: String,
        /// The program or the library.
        what: String,
    },
    /// There was no answer in time.
    #[error("`{command}` has not answered to {what} within {seconds} s{}", quoted(.last_words))]
    Silent {
        /// The command.
        command: String,
        /// What was asked.
        what: String,
        /// How long it was waited for, in seconds.
        seconds: f64,
        /// End of what it has written to standard error.
        last_words: String,
    },
    /// It has ended, or closed its standard output.
    #[error("`{command}` has ended ({status}) when asked for {what}{}", quoted(.last_words))]
    Ended {
        /// The command.
        command: String,
        /// What was asked.
        what: String,
        /// How it ended, as far as that is known.
        status: String,
        /// End of what it has written to standard error.
        last_words: String,
    },
    /// It has answered something else than the protocol says.
    #[error(
        "`{command}` has answered to {what} with {found}, expected {expected}{}",
        quoted(.last_words)
    )]
    Protocol {
        /// The command.
        command: String,
        /// What was asked.
        what: String,
        /// What would be right.
        expected: String,
        /// What came.
        found: String,
        /// End of what it has written to standard error.
        last_words: String,
    },
    /// A simulator in the same program, in another language, has raised an error.
    #[error("`{simulator}` has raised an error when asked for {what}: {message}")]
    Raised {
        /// The simulator.
        simulator: String,
        /// What was asked.
        what: String,
        /// What it says.
        message: String,
    },
    /// An FMU cannot be loaded, or one of its functions failed.
    #[error("{file}: {what}: expected {expected}, found {found}")]
    Fmu {
        /// The FMU.
        file: String,
        /// Where in it.
        what: String,
        /// What would be right.
        expected: String,
        /// What is there.
        found: String,
    },
}

fn quoted(last_words: &str) -> String {
    if last_words.is_empty() {
        return String::new();
    }
    let lines = last_words.lines().map(|line| format!("\n  | {line}"));
    format!("; the end of its standard error:{}", lines.collect::<String>())
}

/// What is said of an entry at a place that makes no sense.
pub(super) fn wrong(
    place: &str,
    key: impl Into<String>,
    expected: impl Into<String>,
    found: impl std::fmt::Display,
) -> OutsideError {
    let (key, expected, found) = (key.into(), expected.into(), found.to_string());
    OutsideError::Value { place: place.to_owned(), key, expected, found }
}
