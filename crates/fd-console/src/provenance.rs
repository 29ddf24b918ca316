//! Where a page is from: version, time, command, and what the inputs were.

use std::{env, fs::File, io::Read, path::Path, time::SystemTime};

use fdiag::model::Shown;
use httpdate::fmt_http_date;
use sha2::{Digest, Sha256};

/// Bytes of a file that are hashed at a time.
const PART: usize = 1 << 16;

/// One line about the program and the command, and one per input file with the beginning of its SHA-256; what cannot be
/// read any more has none.
pub(crate) fn provenance(inputs: &[&Path]) -> Vec<String> {
    let now = fmt_http_date(SystemTime::now());
    let program = format!("{} {}, {now}: `{}`", name(), env!("CARGO_PKG_VERSION"), command());
    let files = inputs.iter().map(|path| {
        let hash = hash(path).map_or_else(|| "not a file".to_owned(), |h| format!("SHA-256 {h}…"));
        format!("`{}`: {hash}", Shown(&path.display().to_string()))
    });
    std::iter::once(program).chain(files).collect()
}

/// The command line as it was given, as a shell takes it; the program by its name alone.
#[must_use]
pub fn command() -> String {
    let arguments = env::args().skip(1).map(|argument| quoted(&argument));
    std::iter::once(name()).chain(arguments).collect::<Vec<_>>().join(" ")
}

/// The name of the program that runs, without its directory.
fn name() -> String {
    let first = env::args_os().next();
    let name = first.as_deref().map(Path::new).and_then(Path::file_stem);
    name.map_or_else(|| "fdiag".to_owned(), |name| name.to_string_lossy().into_owned())
}

/// An argument as a shell takes it.
fn quoted(argument: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+%@".contains(c);
    let argument = Shown(argument).to_string();
    if !argument.is_empty() && argument.chars().all(is_plain) {
        argument
    } else {
        format!("'{}'", argument.replace('\'', "'\\''"))
    }
}

/// The first eight bytes of the hash, which nobody mistakes.
fn hash(path: &Path) -> Option<String> {
    let mut file = File::open(path).ok()?;
    let (mut hasher, mut part) = (Sha256::new(), vec![0; PART]);
    loop {
        match file.read(&mut part).ok()? {
            0 => break,
            n => hasher.update(part.get(..n)?),
        }
    }
    let first = *hasher.finalize().first_chunk()?;
    Some(format!("{:016x}", u64::from_be_bytes(first)))
}
