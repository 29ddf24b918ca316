//! Files of text that people write: small ones.

use std::{
    fs::File,
    io::{self, Read},
    path::Path,
};

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
    let mut text = String::new();
    File::open(path)?.take(most.saturating_add(1)).read_to_string(&mut text)?;
    if most < text.len() as u64 {
        let reason = format!("expected at most {most} bytes (limit `bytes`), found more");
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, reason));
    }
    Ok(text)
}
