//! `fdiag watch --replay`: what the journal of a monitor tells, for an audit.

use std::{fs::File, io::BufReader, path::Path};

use fd_watch::Audit;

use super::super::{
    failure::{ExitCode, Failure},
    say::say,
};

/// Prints the alarms of a state folder or of a file of messages. Nothing is locked or written: a monitor may be at work.
pub(super) fn run(path: &Path) -> Result<ExitCode, Failure> {
    let journal = if path.is_dir() { path.join("journal.ndjson") } else { path.to_owned() };
    let failed = |error| Failure::input(&journal, error);
    let file = File::open(&journal).map_err(failed)?;
    let audit = Audit::read(BufReader::new(file)).map_err(failed)?;
    say(&audit.to_string())?;
    Ok(ExitCode::SUCCESS)
}
