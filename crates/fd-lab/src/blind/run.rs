//! `fdiag-lab blind run`.

use std::{fs, path::Path};

use fd_gap::diagnose::Settings;
use fd_model::Record;
use fd_sim::model::Model;
use rayon::prelude::*;

use super::{
    answer::{Answer, read_answers},
    baselines,
    diagnose::{Manner as How, answer, as_black_box},
    error::BlindError,
    feature::{Feature, Method},
    files::COMMITMENT,
    files::{Case, Variant, answers},
    make::CASES,
};
use crate::{black_box::Sight, journal::Journal};
use fdiag::Watcher;

/// How cases are diagnosed.
#[derive(Clone, Copy)]
pub struct Manner<'a> {
    /// In which form.
    pub variant: Variant,
    /// What is left out, to see what it brings; only where the plant is no black box.
    pub without: Option<Feature>,
    /// Whether simpler methods are run, too.
    pub with_baselines: bool,
    /// Settings of a diagnosis, from the model and both logs.
    pub settings: &'a ChooseSettings<'a>,
}

/// Settings of a diagnosis, from the model and both logs.
pub type ChooseSettings<'a> =
    dyn Fn(&Model, &[Record; 2]) -> Result<Settings, BlindError> + Sync + 'a;

impl Default for Manner<'_> {
    /// As it was logged, with all methods, in free run.
    fn default() -> Self {
        let settings = &|_: &Model, _: &[Record; 2]| Ok(Settings::default());
        Self { variant: Variant::AsLogged, without: None, with_baselines: true, settings }
    }
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

fn answer_of(case: &Case, manner: &Manner<'_>) -> Result<Answer, BlindError> {
    let method = Method { without: manner.without };
    let (model, logs) = case.read(manner.variant, method.held_inputs())?;
    let settings = (manner.settings)(&model, &logs)?;
    let [train, held_out] = &logs;
    let black_box = |how| as_black_box(&case.name, &model, &logs, &settings, how);
    let mut answer = match manner.variant {
        Variant::BlackBox => black_box(How::Thorough)?,
        Variant::FewRuns => black_box(How::Sparing(Sight::States))?,
        Variant::FewRunsOfOutputs => black_box(How::Sparing(Sight::Outputs))?,
        Variant::FewWholeRuns => black_box(How::Sparing(Sight::Runs))?,
        _ => answer(&case.name, &model, train, held_out, &settings, method)?,
    };
    if manner.with_baselines {
        // Simpler methods are not made for holes; what they cannot do is no fault of the diagnosis.
        answer.baselines = baselines::all(&model, train, held_out).ok();
    }
    Ok(answer)
}

/// Diagnoses every case that has no answer yet, adds the answers to `answers.jsonl` (or, of another
/// form, to a file of its own), and says how many cases have one now. A diagnosis that fails is an
/// answer, too: one without causes.
///
/// # Errors
///
/// Returns an error when the directory has no cases, the answers cannot be read or written, or the watcher stops it.
pub fn run(
    directory: &Path,
    manner: &Manner<'_>,
    watcher: &impl Watcher,
) -> Result<usize, BlindError> {
    let path = directory.join(answers(manner.variant, manner.without));
    let known = read_answers(&path)?;
    let cases: Vec<Case> =
        cases(directory)?.into_iter().filter(|case| case.has(manner.variant)).collect();
    let is_open = |case: &&Case| !known.iter().any(|answer| answer.case == case.name);
    let open: Vec<&Case> = cases.iter().filter(is_open).collect();
    watcher.begin(cases.len() as u64, (cases.len() - open.len()) as u64);
    let journal = Journal::open(&path)?;
    open.par_iter().try_for_each(|case| {
        if watcher.is_stopped() {
            return Err(BlindError::Stopped);
        }
        let answer = answer_of(case, manner).unwrap_or_else(|error| Answer {
            case: case.name.clone(),
            error: Some(error.to_string()),
            no_gap: 1.0,
            ..Answer::default()
        });
        journal.append(&answer)?;
        watcher.advance();
        Ok(())
    })?;
    Ok(cases.len())
}
