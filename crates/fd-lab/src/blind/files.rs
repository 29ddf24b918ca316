//! The files of a case.
//!
//! Beside the model and the logs as people have them, some cases have the same experiment as it
//! could have been: with the controller in the model, or as separate runs from rest.

use std::{
    fs,
    path::{Path, PathBuf},
};

use fd_log::{LogMap, TimeMap, read_log, write_log_to};
use fd_model::{Channel, HeldInputs, Record};
use fd_sim::model::Model;

use super::{
    conditions::Conditions,
    error::BlindError,
    feature::Feature,
    logs::{LogOfRun, Part},
    truth::{Scene, Truth},
};

/// Name of the file with the commitment, in the directory of a case.
pub(super) const COMMITMENT: &str = "commitment.sha256";

/// In which form a case is diagnosed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Variant {
    /// As it was logged.
    #[default]
    AsLogged,
    /// With the controller in the model, where there is one.
    KnownController,
    /// From separate runs that begin at rest, where it was not.
    FromRest,
    /// As it was logged, with the plant as a black box.
    BlackBox,
    /// The same with few runs of the plant.
    FewRuns,
    /// The same where nothing of the plant can be seen but its outputs, in single precision.
    FewRunsOfOutputs,
    /// The same where it makes whole runs only.
    FewWholeRuns,
}

/// The model, and that with the controller in it.
const MODEL: &str = "model.toml";
const WITH_CONTROLLER: &str = "model_with_controller.toml";
/// The logs to fit and to hold out, and those of separate runs from rest.
const LOGS: [&str; 2] = ["train.csv", "held_out.csv"];
const FROM_REST: [&str; 2] = ["train_from_rest.csv", "held_out_from_rest.csv"];

/// A case as a user has it.
pub(super) struct Case {
    pub name: String,
    pub directory: PathBuf,
}

/// Name of the file of answers in a form, by a method that may be without something.
pub(super) fn answers(variant: Variant, without: Option<Feature>) -> String {
    let without = without.map(|feature| format!("_without_{}", feature.name().replace('-', "_")));
    format!("answers{}{}.jsonl", variant.name(), without.unwrap_or_default())
}

impl Variant {
    fn name(self) -> &'static str {
        match self {
            Self::AsLogged => "",
            Self::KnownController => "_known_controller",
            Self::FromRest => "_from_rest",
            Self::BlackBox => "_black_box",
            Self::FewRuns => "_few_runs",
            Self::FewRunsOfOutputs => "_few_runs_of_outputs",
            Self::FewWholeRuns => "_few_whole_runs",
        }
    }

    fn model(self) -> &'static str {
        if self == Self::KnownController { WITH_CONTROLLER } else { MODEL }
    }

    fn logs(self) -> [&'static str; 2] {
        if self == Self::FromRest { FROM_REST } else { LOGS }
    }
}

impl Case {
    /// The model as it came, without any controller of the bench.
    pub(super) fn model(&self) -> Result<Model, BlindError> {
        self.model_of(Variant::AsLogged)
    }

    fn model_of(&self, variant: Variant) -> Result<Model, BlindError> {
        Model::load(&self.directory.join(variant.model()))
            .map_err(|error| BlindError::Model { error: Box::new(error) })
    }

    /// Whether it can be diagnosed in this form.
    pub(super) fn has(&self, variant: Variant) -> bool {
        let files = [variant.model(), variant.logs()[0]];
        files.iter().all(|file| self.directory.join(file).is_file())
    }

    /// The model and both logs, with inputs between samples that are held so.
    pub(super) fn read(
        &self,
        variant: Variant,
        held_inputs: HeldInputs,
    ) -> Result<(Model, [Record; 2]), BlindError> {
        let model = self.model_of(variant)?;
        let mut map = LogMap::for_channels(&model.external_inputs(), &model.output_channels());
        let (time, ts) = (Some("time".to_owned()), Some(model.sample_time));
        map.resample.held_inputs = Some(held_inputs);
        map.time = TimeMap { column: time, sample_time: ts, ..TimeMap::default() };
        // The column of the command is called as the input that it drives.
        for column in &mut map.outputs {
            let input = model.inputs.iter().find(|input| {
                let is_shown = model.is_driven(&input.name) && variant == Variant::KnownController;
                is_shown && column.name.starts_with(&format!("{}_command", input.name))
            });
            if let Some(input) = input {
                column.column = Some(input.name.clone());
            }
        }
        let log =
            |file: &str| Ok::<_, BlindError>(read_log(self.directory.join(file), &map)?.record);
        let [train, held_out] = variant.logs();
        Ok((model, [log(train)?, log(held_out)?]))
    }

    pub(super) fn commitment(&self) -> Result<String, BlindError> {
        let file = self.directory.join(COMMITMENT);
        fs::read_to_string(&file).map_err(BlindError::file(&file))
    }
}

/// Writes the models and the logs of a case; `None` when the plant diverges.
pub(super) fn write_case(scene: &Scene<'_>, directory: &Path) -> Result<Option<()>, BlindError> {
    fs::create_dir_all(directory).map_err(BlindError::file(directory))?;
    write(&directory.join(MODEL), scene.model.to_string())?;
    if let Some(controller) = &scene.truth.conditions.controller
        && let Some(closed) = controller.in_model(scene.model)?
    {
        write(&directory.join(WITH_CONTROLLER), closed.to_string())?;
    }
    if logs(scene, directory, LOGS)?.is_none() {
        return Ok(None);
    }
    let conditions = &scene.truth.conditions;
    if conditions.is_cut || 0 < conditions.before {
        let conditions = Conditions { is_cut: false, before: 0, ..conditions.clone() };
        let truth = Truth { conditions, ..scene.truth.clone() };
        return logs(&Scene::new(&truth, scene.model)?, directory, FROM_REST);
    }
    Ok(Some(()))
}

fn logs(scene: &Scene<'_>, directory: &Path, files: [&str; 2]) -> Result<Option<()>, BlindError> {
    let parts = if scene.truth.conditions.is_cut {
        [(0, Part::First), (0, Part::Second)]
    } else {
        [(0, Part::First), (1, Part::First)]
    };
    for ((run, part), file) in parts.into_iter().zip(files) {
        let Some(log) = scene.log_of(run, part, true)? else { return Ok(None) };
        let path = directory.join(file);
        write(&path, text(&path, &log)?)?;
    }
    Ok(Some(()))
}

/// A log as text, with the reference among the inputs, without the rows that are lost.
fn text(path: &Path, log: &LogOfRun) -> Result<Vec<u8>, BlindError> {
    let mut record = log.record.clone();
    if let Some((channel, values)) = &log.reference {
        let inputs: Vec<Channel> = [record.inputs(), std::slice::from_ref(channel)].concat();
        let row = |k: usize| record.u(k).iter().copied().chain([values[k]]).collect::<Vec<f64>>();
        let u = (0..record.len()).flat_map(row).collect();
        let y = (0..record.len()).flat_map(|k| record.y(k).to_vec()).collect();
        let start = record.time(0);
        record = Record::new(inputs, record.outputs().to_vec(), u, y, record.ts())?;
        record = record.starting_at(start);
    }
    let mut text = Vec::new();
    write_log_to(&path.display().to_string(), &mut text, &record)?;
    if log.is_kept.iter().all(|is_kept| *is_kept) {
        return Ok(text);
    }
    // Two lines of head, then the rows.
    let lines = text.split_inclusive(|byte| *byte == b'\n').enumerate();
    let is_there = |line: usize| line < 2 || log.is_kept.get(line - 2).is_none_or(|kept| *kept);
    Ok(lines.filter(|(i, _)| is_there(*i)).flat_map(|(_, line)| line).copied().collect())
}

pub(super) fn write(file: &Path, content: impl AsRef<[u8]>) -> Result<(), BlindError> {
    fs::write(file, content).map_err(BlindError::file(file))
}
