//! What is asked, as the side of Python says it: JSON with one entry per option of the command line.

use std::{fs, path::PathBuf, str::FromStr};

use fd_log::{LogMap, LogTable};
use fd_model::Disorder;
use fdiag::{
    core::Limits,
    effect::text::TextEffects,
    gap_study::{Budget, HeldOutChoice, Named, Request, ResampleChoice},
};
use pyo3::prelude::*;
use serde::Deserialize;

use crate::errors::input;

/// The settings of a study; what is left out is as on the command line.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[expect(clippy::struct_excessive_bools, reason = "each is a switch of its own")]
pub(crate) struct Settings {
    split: Option<f64>,
    horizon: Option<String>,
    effects: TextEffects,
    exclude: Vec<String>,
    only: Vec<String>,
    tolerances: Vec<(String, f64)>,
    noise: Vec<(String, f64)>,
    columns: Option<LogMap>,
    sample_time: Option<f64>,
    longest_hole: Option<f64>,
    drop_disorder: bool,
    as_read: bool,
    starts: Option<String>,
    controller_sees: Option<String>,
    calibrate: Option<usize>,
    most: Option<usize>,
    seed: Option<u64>,
    budget: Option<String>,
    thorough: bool,
    yes: bool,
}

impl Settings {
    /// From JSON; the message says which entry is wrong.
    pub(crate) fn read(json: &str) -> Result<Self, String> {
        serde_json::from_str(json).map_err(|error| format!("settings: {error}"))
    }

    /// The request that these settings make of a model and logs.
    pub(crate) fn request(
        self,
        model: PathBuf,
        [logs, held_out]: [Vec<PathBuf>; 2],
        tables: Vec<LogTable>,
    ) -> Result<Request, String> {
        let plain = Request::new(model, logs);
        let named = |all: Vec<(String, f64)>| {
            all.into_iter().map(|(name, value)| Named { name, value }).collect::<Vec<_>>()
        };
        let held_out = if held_out.is_empty() {
            self.split.map_or(plain.held_out.clone(), HeldOutChoice::Split)
        } else {
            HeldOutChoice::Logs(held_out)
        };
        let horizon = chosen("horizon", self.horizon)?;
        let disorder = if self.drop_disorder { Disorder::Drop } else { Disorder::Reject };
        let budget = self.budget.map(|text| text.parse::<Budget>()).transpose();
        let budget = budget.map_err(|error| format!("budget: {error}"))?;
        let starts = chosen("starts", self.starts)?;
        let controller_sees = chosen("controller_sees", self.controller_sees)?;
        let effects = self.effects.effects().map_err(|error| error.to_string())?;
        Ok(Request {
            effects,
            budget,
            thorough: self.thorough,
            tables,
            columns: self.columns,
            held_out,
            horizon,
            exclude: self.exclude,
            only: self.only,
            tolerances: named(self.tolerances),
            noise: named(self.noise),
            resample: ResampleChoice {
                sample_time: self.sample_time,
                longest_gap: self.longest_hole,
                disorder,
            },
            most: self.most.unwrap_or(plain.most),
            as_read: self.as_read,
            starts,
            controller_sees,
            seed: self.seed.unwrap_or(plain.seed),
            calibrate: self.calibrate,
            limits: Limits {
                steps: if self.yes { u64::MAX } else { plain.limits.steps },
                ..plain.limits
            },
            ..plain
        })
    }
}

/// A choice by its word; without one, as it is by default.
fn chosen<T: Default + FromStr<Err = String>>(
    what: &str,
    word: Option<String>,
) -> Result<T, String> {
    word.map_or_else(
        || Ok(T::default()),
        |word| word.parse().map_err(|error| format!("{what}: {error}, found `{word}`")),
    )
}

/// A column map out of a TOML file, as JSON.
#[pyfunction]
#[pyo3(signature = (file, /))]
pub(crate) fn column_map(py: Python<'_>, file: PathBuf) -> PyResult<String> {
    let failed = |error: &dyn ToString| {
        let error = format!("{}: {}", file.display(), error.to_string());
        input(py, &error)
    };
    let text = fs::read_to_string(&file).map_err(|error| failed(&error))?;
    let map: LogMap = toml::from_str(&text).map_err(|error| failed(&error))?;
    serde_json::to_string(&map).map_err(|error| failed(&error))
}
