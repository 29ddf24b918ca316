//! Model files, read and written.

use std::path::Path;

use fd_core::Limits;

use crate::file::{
    atomic::write_atomically,
    model::LinearModel,
    model_error::{FileAction, ModelFileError},
    model_parse, model_write,
    text::read_text,
};

impl LinearModel {
    /// Reads a model file.
    ///
    /// # Errors
    ///
    /// As [`LinearModel::parse`], and when the file cannot be read.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, ModelFileError> {
        let path = path.as_ref();
        let file = path.display().to_string();
        let text = read_text(path, Limits::default().bytes)
            .map_err(|error| io_error(&file, FileAction::Read, &error))?;
        Self::parse(&file, &text)
    }

    /// Reads the text of a model file; `file` is the name for errors.
    ///
    /// # Errors
    ///
    /// Returns an error with the place in the file when it is not TOML, has wrong, unknown or
    /// missing keys or another version, when matrices do not fit the channels or are not finite,
    /// when an operating point or scale is out of range, or when the model is unstable without
    /// saying so.
    pub fn parse(file: &str, text: &str) -> Result<Self, ModelFileError> {
        let model = model_parse::parse(file, text)?;
        model.check(file)?;
        Ok(model)
    }

    /// Writes a model file, completely or not at all. Reading it back gives the same model to the
    /// bit.
    ///
    /// # Errors
    ///
    /// Returns an error when the file cannot be written, or could not be read back: channels do
    /// not fit the matrices, a name is used twice, an operating point or scale is out of range,
    /// or the model is unstable without saying so.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), ModelFileError> {
        let path = path.as_ref();
        let file = path.display().to_string();
        self.check(&file)?;
        write_atomically(path, |out| out.write_all(self.to_toml().as_bytes()))
            .map_err(|error| io_error(&file, FileAction::Write, &error))
    }

    /// The text of the model file.
    #[must_use]
    pub fn to_toml(&self) -> String {
        model_write::to_toml(self)
    }
}

fn io_error(file: &str, action: FileAction, error: &std::io::Error) -> ModelFileError {
    ModelFileError::Io { file: file.to_owned(), action, kind: error.kind() }
}
