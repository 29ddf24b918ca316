//! What a study is made from: files as they were asked for, and records as they were read.

use std::path::{Path, PathBuf};

use fd_core::Limits;
use fd_log::{LogMap, read_log};
use fd_model::{Record, TimeBaseReport, file::LinearModel};
use fdiag::{spec::PipelineSpec, training::TrainingError};

use super::error::LogStudyError;

/// Which files are to be studied, and how.
#[derive(Clone, Debug)]
pub struct Request {
    /// Model file of the nominal plant.
    pub model: PathBuf,
    /// Logs of the healthy plant.
    pub healthy: Vec<PathBuf>,
    /// Logs to be diagnosed.
    pub logs: Vec<PathBuf>,
    /// Column map; none finds columns by channel name.
    pub columns: Option<LogMap>,
    /// The diagnosis.
    pub spec: PipelineSpec,
    /// Share of each healthy log, from its start, that the bias is learned from; the threshold is
    /// taken from the rest.
    pub share_to_learn: f64,
    /// How large logs and numbers of the spec may be.
    pub limits: Limits,
}

/// What is studied: a model and records, wherever they come from.
#[derive(Clone, Debug)]
pub struct Material {
    /// The nominal plant.
    pub model: LinearModel,
    /// Its name in reports.
    pub name: String,
    /// Records in units of the model, all on the time base of the first; healthy ones first.
    pub logs: Vec<StudiedLog>,
    /// The diagnosis.
    pub spec: PipelineSpec,
    /// Share of each healthy log, from its start, that the bias is learned from.
    pub share_to_learn: f64,
    /// How large numbers of the spec may be.
    pub limits: Limits,
}

/// A record with its history.
#[derive(Clone, Debug)]
pub struct StudiedLog {
    /// What it is called in reports.
    pub file: PathBuf,
    /// The signals.
    pub record: Record,
    /// What the time base of the file was like.
    pub time_base: TimeBaseReport,
    /// Whether the plant was healthy.
    pub healthy: bool,
}

impl Request {
    /// Reads the files.
    ///
    /// # Errors
    ///
    /// Returns the first file or row that is wrong.
    pub fn read(&self) -> Result<Material, LogStudyError> {
        self.spec.check_limits(&self.limits).map_err(TrainingError::from)?;
        let model = LinearModel::read(&self.model)?;
        let mut map = self.columns.clone().unwrap_or_else(|| LogMap::for_model(&model));
        map.resample.limits = self.limits;
        if let Some(ts) = model.system.sample_time() {
            map.resample.sample_time.get_or_insert(ts.seconds());
        }
        let healthy = self.healthy.iter().map(|path| (path, true));
        let mut logs = Vec::new();
        for (path, healthy) in healthy.chain(self.logs.iter().map(|path| (path, false))) {
            let (record, time_base) = read(path, &model, &map)?;
            // All logs are brought onto the time base of the first.
            map.resample.sample_time.get_or_insert(record.ts().seconds());
            logs.push(StudiedLog { file: path.clone(), record, time_base, healthy });
        }
        Ok(Material {
            name: model.name.clone().unwrap_or_else(|| self.model.display().to_string()),
            model,
            logs,
            spec: self.spec.clone(),
            share_to_learn: self.share_to_learn,
            limits: self.limits,
        })
    }
}

fn read(
    path: &Path,
    model: &LinearModel,
    map: &LogMap,
) -> Result<(Record, TimeBaseReport), LogStudyError> {
    let log = read_log(path, map)?;
    let scaled = log.record.scaled(&model.scaling()).map_err(|source| LogStudyError::Record {
        file: path.to_owned(),
        source: Box::new(source),
    })?;
    Ok((scaled, log.time_base))
}
