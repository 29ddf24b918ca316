//! The simulator of a model file, with what its user knows better than the file.

use std::{fs, path::Path};

use fd_gap::{
    effect::with_default_sites,
    fit::FitError,
    model::{Draft, LinearOptions, LoadError, Model},
};
use fd_model::{
    SampleTime,
    file::{ColumnMap, LinearModel, LogMap, read_log},
};

use super::{
    error::GapError,
    request::{Named, Request},
};

/// Kinds of model files that can be diagnosed.
const KINDS: &str = "`equations` or `state-space`";

/// The model that a request diagnoses: that of its file, with the tolerances and the noise of the
/// request, and a site of forces at every state equation.
///
/// # Errors
///
/// Returns what is wrong with the file or a setting.
pub fn model_of(request: &Request) -> Result<Model, GapError> {
    let model = read(request)?;
    let mut draft = with_default_sites(&model).into_draft();
    for Named { name, value } in &request.tolerances {
        let known = draft.parameters.iter().map(|p| p.name.clone()).collect();
        let parameter = draft.parameters.iter_mut().find(|p| p.name == *name);
        let parameter = parameter.ok_or_else(|| GapError::Unknown {
            option: "--tolerance",
            what: "parameter",
            name: name.clone(),
            known,
        })?;
        parameter.tolerance = *value;
    }
    for Named { name, value } in &request.noise {
        let known = draft.outputs.iter().map(|o| o.name.clone()).collect();
        let output = draft.outputs.iter_mut().find(|o| o.name == *name);
        let output = output.ok_or_else(|| GapError::Unknown {
            option: "--noise",
            what: "output",
            name: name.clone(),
            known,
        })?;
        if *value <= 0.0 {
            let expected = "a standard deviation above 0";
            let found = format!("{name}={value}");
            return Err(GapError::Setting { option: "--noise", expected, found });
        }
        output.noise = Some(*value);
    }
    settled(draft, &request.model)
}

fn settled(draft: Draft, file: &Path) -> Result<Model, GapError> {
    let file = file.display().to_string();
    Ok(Model::try_from(draft).map_err(|error| LoadError::Model { file, error })?)
}

/// Reads a model file, of which the kind is looked at first.
fn read(request: &Request) -> Result<Model, GapError> {
    let path = &request.model;
    let file = path.display().to_string();
    let text = fs::read_to_string(path)
        .map_err(|error| LoadError::Read { file: file.clone(), message: error.to_string() })?;
    // What is no TOML at all is an error of the reader of equations, which says where.
    let kind = text.parse::<toml::Table>().ok();
    let kind = kind.as_ref().and_then(|table| table.get("kind")).and_then(toml::Value::as_str);
    match kind {
        Some("equations") | None => {
            Ok(text.parse().map_err(|error| LoadError::Model { file, error })?)
        }
        Some("state-space") => {
            let linear = LinearModel::parse(&file, &text)?;
            let ts = linear_pace(request, &linear)?;
            let model = Model::from_linear(&linear, ts, &LinearOptions::default());
            Ok(model.map_err(|error| LoadError::Model { file, error })?)
        }
        Some(found) => {
            Err(GapError::Kind { file: path.clone(), found: found.to_owned(), expected: KINDS })
        }
    }
}

/// The time between samples of a linear model: its own, that of the request, or that of the first
/// log.
fn linear_pace(request: &Request, linear: &LinearModel) -> Result<SampleTime, GapError> {
    if let Some(ts) = linear.system.sample_time() {
        return Ok(ts);
    }
    if let Some(seconds) = request.resample.sample_time {
        return Ok(SampleTime::new(seconds)?);
    }
    let mut map = LogMap::for_model(linear);
    if let Some(columns) = &request.columns {
        complete(&mut map, columns);
    }
    let first = request.logs.first().ok_or(FitError::NoLog)?;
    Ok(read_log(first, &map)?.record.ts())
}

/// A map with what the user says put in the place of what follows from the model.
fn complete(map: &mut LogMap, columns: &LogMap) {
    let keep = |of: &[ColumnMap], known: &[ColumnMap]| -> Vec<ColumnMap> {
        let rest = of.iter().filter(|c| !known.iter().any(|k| k.name == c.name));
        known.iter().chain(rest).cloned().collect()
    };
    let (inputs, outputs) =
        (keep(&map.inputs, &columns.inputs), keep(&map.outputs, &columns.outputs));
    *map = LogMap { inputs, outputs, ..columns.clone() };
}
