//! From the text of a model file to a model.

use std::ops::Range;

use faer::Mat;
use serde::Deserialize;
use toml::Spanned;

use crate::{
    channel::Channel,
    domain::{Continuous, Discrete, SampleTime},
    error::ModelError,
    file::{
        model::{LinearModel, LinearSystem, ModelChannel},
        model_error::ModelFileError,
    },
    record::ChannelScale,
    shown::is_plain,
    state_space::StateSpace,
};

pub(super) const VERSION: u32 = 1;
pub(super) const KIND: &str = "state-space";

/// What every version of the format has.
#[derive(Deserialize)]
struct Preamble {
    version: i64,
    kind: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    #[serde(rename = "version")]
    _version: i64,
    #[serde(rename = "kind")]
    _kind: String,
    name: Option<String>,
    sample_time: Option<f64>,
    #[serde(default)]
    allow_unstable: bool,
    #[serde(default)]
    inputs: Vec<ChannelEntry>,
    #[serde(default)]
    states: Vec<ChannelEntry>,
    outputs: Vec<ChannelEntry>,
    matrices: Matrices,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ChannelEntry {
    name: String,
    #[serde(default = "pure_number")]
    unit: String,
    #[serde(default)]
    operating_point: f64,
    scale: Option<f64>,
}

type Rows = Spanned<Vec<Spanned<Vec<f64>>>>;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Matrices {
    #[serde(rename = "A")]
    a: Rows,
    #[serde(rename = "B")]
    b: Rows,
    #[serde(rename = "C")]
    c: Rows,
    #[serde(rename = "D")]
    d: Option<Rows>,
}

fn pure_number() -> String {
    "1".to_owned()
}

impl Document {
    /// Names and units stand in reports and in headers of logs.
    fn check_texts(&self, file: &str) -> Result<(), ModelFileError> {
        let name = self.name.iter().map(|name| ("`name`", name));
        let rooms = [&self.inputs, &self.states, &self.outputs];
        let entries = rooms.into_iter().flatten();
        let channels = entries.flat_map(|e| [("name of a channel", &e.name), ("unit", &e.unit)]);
        match name.chain(channels).find(|(_, text)| !is_plain(text)) {
            None => Ok(()),
            Some((what, found)) => {
                let (file, found) = (file.to_owned(), found.clone());
                Err(ModelFileError::NotPlain { file, what, found })
            }
        }
    }
}

impl From<ChannelEntry> for ModelChannel {
    fn from(entry: ChannelEntry) -> Self {
        let scale = ChannelScale { offset: entry.operating_point, scale: entry.scale };
        Self { channel: Channel::new(entry.name, entry.unit), scale }
    }
}

pub(super) fn parse(file: &str, text: &str) -> Result<LinearModel, ModelFileError> {
    let place = Place { file, text };
    let Preamble { version, kind } = toml::from_str(text).map_err(|e| place.syntax(&e))?;
    if version != i64::from(VERSION) {
        let (file, expected) = (file.to_owned(), VERSION);
        return Err(ModelFileError::Version { file, expected, found: version });
    }
    if kind != KIND {
        return Err(ModelFileError::Kind { file: file.to_owned(), expected: KIND, found: kind });
    }
    let document: Document = toml::from_str(text).map_err(|e| place.syntax(&e))?;
    document.check_texts(file)?;

    let Matrices { a, b, c, d } = document.matrices;
    let (nu, ny) = (document.inputs.len(), document.outputs.len());
    let nx = if document.states.is_empty() { a.as_ref().len() } else { document.states.len() };
    let (inputs, states, outputs) = ((nu, "input"), (nx, "state"), (ny, "output"));
    let a = place.matrix("matrices.A", &a, states, states)?;
    let b = place.matrix("matrices.B", &b, states, inputs)?;
    let c = place.matrix("matrices.C", &c, outputs, states)?;
    let d = match d {
        Some(d) => place.matrix("matrices.D", &d, outputs, inputs)?,
        None => Mat::zeros(ny, nu),
    };
    let wrong = |source: ModelError| ModelFileError::Model { file: file.to_owned(), source };
    let system = match document.sample_time {
        None => LinearSystem::Continuous(StateSpace::new(a, b, c, d, Continuous).map_err(wrong)?),
        Some(seconds) => {
            let ts = SampleTime::new(seconds).map_err(wrong)?;
            let model = StateSpace::new(a, b, c, d, Discrete { ts });
            LinearSystem::Discrete(model.map_err(wrong)?)
        }
    };
    let channels =
        |entries: Vec<ChannelEntry>| entries.into_iter().map(ModelChannel::from).collect();
    Ok(LinearModel {
        name: document.name,
        inputs: channels(document.inputs),
        states: channels(document.states),
        outputs: channels(document.outputs),
        system,
        allow_unstable: document.allow_unstable,
    })
}

/// Makes errors that say where in the file they are.
struct Place<'a> {
    file: &'a str,
    text: &'a str,
}

impl Place<'_> {
    fn matrix(
        &self,
        key: &'static str,
        rows: &Rows,
        (nrows, row_per): (usize, &'static str),
        (ncols, column_per): (usize, &'static str),
    ) -> Result<Mat<f64>, ModelFileError> {
        let file = || self.file.to_owned();
        let entries = rows.as_ref();
        if entries.len() != nrows {
            return Err(ModelFileError::Rows {
                file: file(),
                line: self.line(rows.span()),
                key,
                per: row_per,
                expected: nrows,
                found: entries.len(),
            });
        }
        for (i, row) in entries.iter().enumerate() {
            let line = self.line(row.span());
            let values = row.as_ref();
            if values.len() != ncols {
                return Err(ModelFileError::Columns {
                    file: file(),
                    line,
                    key,
                    row: i,
                    per: column_per,
                    expected: ncols,
                    found: values.len(),
                });
            }
            if let Some(column) = values.iter().position(|v| !v.is_finite()) {
                let value = values[column];
                return Err(ModelFileError::NonFinite {
                    file: file(),
                    line,
                    key,
                    row: i,
                    column,
                    value,
                });
            }
        }
        Ok(Mat::from_fn(nrows, ncols, |i, j| entries[i].as_ref()[j]))
    }

    fn syntax(&self, error: &toml::de::Error) -> ModelFileError {
        let span = error.span().unwrap_or(0..0);
        let before = self.text.get(..span.start).unwrap_or_default();
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        ModelFileError::Syntax {
            file: self.file.to_owned(),
            line: self.line(span),
            column: before[line_start..].chars().count() + 1,
            message: error.message().to_owned(),
        }
    }

    /// Line of a place in the text, from 1.
    fn line(&self, span: Range<usize>) -> usize {
        let before = self.text.get(..span.start).unwrap_or_default();
        before.bytes().filter(|byte| *byte == b'\n').count() + 1
    }
}
