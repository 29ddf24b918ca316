//! `fdiag blind run`.

use std::{
    fs,
    path::{Path, PathBuf},
};

use fd_log::{LogMap, TimeMap, read_log};
use fd_model::Record;
use fd_sim::model::Model;
use rayon::prelude::*;

use super::{
    answer::{Answer, read_answers},
    baselines,
    diagnose::answer,
    error::BlindError,
    make::{CASES, COMMITMENT},
};
use crate::journal::Journal;

/// Name of the file of answers.
pub(super) const ANSWERS: &str = "answers.jsonl";

/// A case as a user has it.
pub(super) struct Case {
    pub(super) name: String,
    pub(super) directory: PathBuf,
}

/// The cases in a directory, by name.
pub(super) fn cases(directory: &Path) -> Result<Vec<Case>, BlindError> {
    let directory = directory.join(CASES);
    let mut all = Vec::new();
    for entry in fs::read_dir(&directory).map_err(BlindError::file(&directory))? {
        let path = entry.map_err(BlindError::file(&directory))?.path();
        if let Some(name) = path.file_name().and_then(|name| name.to_str())
            && path.join(COMMITMENT).is_file()
        {
            all.push(Case { name: name.to_owned(), directory: path.clone() });
        }
    }
    all.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(all)
}

impl Case {
    pub(super) fn model(&self) -> Result<Model, BlindError> {
        Model::load(&self.directory.join("model.toml"))
            .map_err(|error| BlindError::Model { error: Box::new(error) })
    }

    pub(super) fn log(&self, model: &Model, file: &str) -> Result<Record, BlindError> {
        let mut map = LogMap::for_channels(&model.external_inputs(), &model.output_channels());
        map.time = TimeMap { sample_time: Some(model.sample_time), ..TimeMap::default() };
        Ok(read_log(self.directory.join(file), &map)?.record)
    }

    pub(super) fn commitment(&self) -> Result<String, BlindError> {
        let file = self.directory.join(COMMITMENT);
        fs::read_to_string(&file).map_err(BlindError::file(&file))
    }

    fn answer(&self, with_baselines: bool) -> Result<Answer, BlindError> {
        let model = self.model()?;
        let (train, held_out) = (self.log(&model, "train.csv")?, self.log(&model, "held_out.csv")?);
        let mut answer = answer(&self.name, &model, &train, &held_out)?;
        if with_baselines {
            answer.baselines = Some(baselines::all(&model, &train, &held_out)?);
        }
        Ok(answer)
    }
}

/// How far a run is before it goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Cases in the directory.
    pub cases: usize,
    /// Cases that have an answer.
    pub answered: usize,
}

/// How many cases there are, and how many have an answer.
///
/// # Errors
///
/// As [`run`].
pub fn progress(directory: &Path) -> Result<Progress, BlindError> {
    let answers = read_answers(&directory.join(ANSWERS))?;
    let cases = cases(directory)?;
    let answered = cases.iter().filter(|c| answers.iter().any(|a| a.case == c.name)).count();
    Ok(Progress { cases: cases.len(), answered })
}

/// Diagnoses every case that has no answer yet and adds the answers to `answers.jsonl`; `done` is
/// called after each. A diagnosis that fails is an answer, too: one without causes.
///
/// # Errors
///
/// Returns an error when the directory has no cases or the answers cannot be read or written.
pub fn run(
    directory: &Path,
    with_baselines: bool,
    done: impl Fn() + Sync,
) -> Result<(), BlindError> {
    let path = directory.join(ANSWERS);
    let known = read_answers(&path)?;
    let cases = cases(directory)?;
    let journal = Journal::open(&path)?;
    cases
        .par_iter()
        .filter(|case| !known.iter().any(|answer| answer.case == case.name))
        .try_for_each(|case| {
            let answer = case.answer(with_baselines).unwrap_or_else(|error| Answer {
                case: case.name.clone(),
                error: Some(error.to_string()),
                no_gap: 1.0,
                ..Answer::default()
            });
            journal.append(&answer)?;
            done();
            Ok(())
        })
}
