//! Files of linear models (TOML): [`LinearModel::read`] and [`LinearModel::write`]; `docs/formats.md` describes
//! them. Logs are read and written by `fd-log`.

mod atomic;
mod model;
mod model_error;
mod model_file;
mod model_parse;
mod model_write;
mod settings;
mod text;

pub use self::{
    atomic::write_atomically,
    model::{LinearModel, LinearSystem, ModelChannel},
    model_error::{FileAction, ModelFileError},
    settings::{SettingsError, parse_settings, read_settings, write_settings},
    text::{NAMED_PIPE, is_named_pipe, read_text},
};

#[cfg(test)]
mod tests;
