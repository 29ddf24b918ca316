//! Files of text that people write: small ones.

use std::{
    fs::File,
    io::{self, Read},
    path::Path,
};

/// What is said of a named pipe; see [`is_named_pipe`].
pub const NAMED_PIPE: &str =
    "found a named pipe, whose writer may never come (`cat PIPE > FILE` makes a file of it)";

/// Whether a path is a named pipe: opening one waits for a writer, for ever if there is none. A pipe that was opened by
/// whoever started the program (`/dev/stdin`, `<(…)` of a shell, which is in `/dev/fd`) is none of these.
///
/// ```
/// assert!(!fd_model::file::is_named_pipe("/dev/stdin".as_ref()));
/// assert!(!fd_model::file::is_named_pipe("no-such-file".as_ref()));
/// ```
#[must_use]
pub fn is_named_pipe(path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let opened = ["/dev/stdin", "/dev/fd/", "/proc/"];
        let is_opened =
            path.to_str().is_some_and(|path| opened.iter().any(|o| path.starts_with(o)));
        !is_opened && path.metadata().is_ok_and(|about| about.file_type().is_fifo())
    }
    #[cfg(not(unix))]
    {
        let _ = path;
        false
    }
}

/// The text of a file of at most so many bytes. No more than that is read, so that what never ends (`/dev/zero`) and what
/// is no file of settings at all is refused at once, whatever size it claims to have.
///
/// ```
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("model.toml");
/// std::fs::write(&path, "version = 1\n")?;
/// assert_eq!(fd_model::file::read_text(&path, 100)?, "version = 1\n");
/// let error = fd_model::file::read_text(&path, 10).map_err(|error| error.to_string());
/// assert_eq!(error, Err("expected at most 10 bytes (limit `bytes`), found more".to_owned()));
/// # Ok::<(), std::io::Error>(())
/// ```
///
/// # Errors
///
/// Returns an error when the file cannot be read, is longer, or is not UTF-8.
pub fn read_text(path: &Path, most: u64) -> io::Result<String> {
    if is_named_pipe(path) {
        let reason = format!("expected a file, {NAMED_PIPE}");
        return Err(io::Error::new(io::ErrorKind::InvalidInput, reason));
    }
    let mut text = String::new();
    File::open(path)?.take(most.saturating_add(1)).read_to_string(&mut text)?;
    if most < text.len() as u64 {
        let reason = format!("expected at most {most} bytes (limit `bytes`), found more");
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, reason));
    }
    Ok(text)
}
