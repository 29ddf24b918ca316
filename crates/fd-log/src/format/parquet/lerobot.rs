//! Datasets of `LeRobot`, versions 2 and 3: a folder with `meta/info.json` and `data/chunk-*/*.parquet`.
//!
//! An episode is a log. `DATASET/episode_3` names one of a dataset, and so does its own file where it has one; a
//! column map can say `rows = [{ column = "episode_index", equals = 3 }]` for the folder. Columns of lists
//! have the names that the dataset states: `action[shoulder_pan]`, `observation.state[shoulder_pan]`. Time is
//! `frame_index` by the stated frames per second.

use std::{
    collections::BTreeMap,
    fs::{self, File},
    path::{Path, PathBuf},
};

use serde::Deserialize;
use serde_json::Value;

use super::{name_of_file, read_plain};
use crate::{
    error::LogError,
    header::HeaderColumn,
    limit::Budget,
    map::LogMap,
    recording::{Recording, Topic},
    source::cannot_read,
};

const EPISODE: &str = "episode_index";
/// Most bytes of `info.json`.
const MOST_INFO: u64 = 16 << 20;

/// What a dataset says of itself.
#[derive(Debug, Deserialize)]
struct Info {
    fps: f64,
    #[serde(default)]
    total_episodes: u64,
    #[serde(default)]
    features: BTreeMap<String, Feature>,
}

#[derive(Debug, Deserialize)]
struct Feature {
    #[serde(default)]
    names: Value,
}

impl Info {
    /// Of the dataset in a folder; nothing if it is none.
    fn read(folder: &Path) -> Result<Option<Self>, LogError> {
        let path = folder.join("meta").join("info.json");
        let file = path.display().to_string();
        if !path.is_file() {
            return Ok(None);
        }
        let damaged =
            |found: String| LogError::Damaged { file: file.clone(), format: "LeRobot", found };
        let length = fs::metadata(&path).map_err(|error| cannot_read(&file, &error))?.len();
        if length > MOST_INFO {
            return Err(damaged(format!("found {length} bytes, more than {MOST_INFO}")));
        }
        let text = fs::read_to_string(&path).map_err(|error| cannot_read(&file, &error))?;
        let info: Self = serde_json::from_str(&text).map_err(|e| damaged(format!("found: {e}")))?;
        if !(info.fps > 0.0 && info.fps.is_finite()) {
            return Err(damaged(format!("found {} frames per second", info.fps)));
        }
        Ok(Some(info))
    }

    /// The name of an entry of a list: `names` is a list, or a dict of one.
    fn name(&self, feature: &str, place: usize) -> Option<&str> {
        let names = &self.features.get(feature)?.names;
        let names = names.as_object().and_then(|dict| dict.values().next()).unwrap_or(names);
        names.get(place)?.as_str()
    }

    /// Puts names into headers, and the clock of the dataset beside them.
    fn complete(&self, recording: &mut Recording) {
        recording.sample_time = Some(1.0 / self.fps);
        for topic in &mut recording.topics {
            for column in &mut topic.columns {
                let parts = column.text.strip_suffix(']').and_then(|text| text.rsplit_once('['));
                let Some((feature, place)) = parts else { continue };
                if let Some(name) = place.parse().ok().and_then(|place| self.name(feature, place)) {
                    let text = format!("{feature}[{name}]");
                    *column = HeaderColumn { name: text.clone(), text, unit: None };
                }
            }
            topic.times = values(topic, "frame_index")
                .map(|frames| frames.iter().map(|frame| frame / self.fps).collect())
                .or_else(|| values(topic, "timestamp").map(<[f64]>::to_vec));
        }
    }
}

fn values<'a>(topic: &'a Topic, name: &str) -> Option<&'a [f64]> {
    let index = topic.columns.iter().position(|column| column.text == name)?;
    topic.values.get(index).map(Vec::as_slice)
}

/// Reads a file as one table; in a dataset of `LeRobot`, with the names and the pace that the dataset states.
pub(in super::super) fn read(file: &str, from: File) -> Result<Recording, LogError> {
    let mut recording = read_plain(file, from, &mut Budget::new(file), &mut |_| true)?;
    name_columns(&mut recording)?;
    Ok(recording)
}

/// Gives a file of a dataset the names and the pace of its dataset; any other file stays as it is.
fn name_columns(recording: &mut Recording) -> Result<(), LogError> {
    // DATASET/data/chunk-000/episode_000000.parquet
    if let Some(folder) = Path::new(&recording.file).ancestors().nth(3)
        && let Some(info) = Info::read(folder)?
    {
        info.complete(recording);
    }
    Ok(())
}

/// Whether a path is the folder of a dataset, or an episode in one.
pub(in crate::format) fn is_dataset(path: &Path) -> bool {
    let has_info = |folder: &Path| folder.join("meta").join("info.json").is_file();
    path.is_dir() && has_info(path)
        || !path.exists() && episode(path).is_some() && path.parent().is_some_and(has_info)
}

/// The number in `DATASET/episode_3`.
fn episode(path: &Path) -> Option<u64> {
    path.file_name()?.to_str()?.strip_prefix("episode_")?.parse().ok()
}

/// Reads one episode.
pub(in crate::format) fn read_dataset(path: &Path, map: &LogMap) -> Result<Recording, LogError> {
    let file = path.display().to_string();
    let folder = if path.is_dir() { path } else { path.parent().unwrap_or(path) };
    let no_log = |expected, found: String| LogError::NoLog { file: file.clone(), expected, found };
    let info = Info::read(folder)?;
    let info = info.ok_or_else(|| no_log("a LeRobot dataset", "found none".to_owned()))?;
    let ruled = map.rows.iter().find(|rule| rule.column == EPISODE).and_then(|rule| rule.equals);
    let stated = if path.is_dir() { None } else { episode(path).map(|n| n as f64) };
    let only = (info.total_episodes == 1).then_some(0.0);
    let Some(wanted) = stated.or(ruled).or(only) else {
        let expected = "an episode: DATASET/episode_0, or in the column map rows = [{ column = \
                        \"episode_index\", equals = 0 }]";
        return Err(no_log(
            expected,
            format!("found a dataset of {} episodes", info.total_episodes),
        ));
    };
    for data in data_files(folder)? {
        // Version 2 has a file per episode, and says which in its name.
        let stem = data.file_stem().map(Path::new);
        if stem
            .and_then(episode)
            .is_some_and(|number| !(wanted..=wanted).contains(&(number as f64)))
        {
            continue;
        }
        let name = name_of_file(&data);
        let open = || File::open(&data).map_err(|error| cannot_read(&name, &error));
        let index =
            read_plain(&name, open()?, &mut Budget::new(&name), &mut |column| column == EPISODE)?;
        let index =
            index.topics.first().and_then(|topic| values(topic, EPISODE)).unwrap_or_default();
        let is_kept = |row: usize| index.get(row).is_some_and(|of| (wanted..=wanted).contains(of));
        if !(0..index.len()).any(is_kept) {
            continue;
        }
        let mut recording = read_plain(&name, open()?, &mut Budget::new(&name), &mut |_| true)?;
        recording.file = file;
        for column in recording.topics.iter_mut().flat_map(|topic| &mut topic.values) {
            let kept = column.iter().enumerate().filter(|(row, _)| is_kept(*row));
            *column = kept.map(|(_, value)| *value).collect();
        }
        info.complete(&mut recording);
        return Ok(recording);
    }
    let found = format!("found no episode {wanted} in its files");
    Err(no_log("the episode that is asked for", found))
}

/// All files of a dataset, in order.
fn data_files(folder: &Path) -> Result<Vec<PathBuf>, LogError> {
    let list = |folder: &Path| -> Result<Vec<PathBuf>, LogError> {
        let name = name_of_file(folder);
        let entries = fs::read_dir(folder).map_err(|error| cannot_read(&name, &error))?;
        let paths = entries.map(|entry| entry.map(|entry| entry.path()));
        let mut paths =
            paths.collect::<Result<Vec<_>, _>>().map_err(|error| cannot_read(&name, &error))?;
        paths.sort();
        Ok(paths)
    };
    let mut files = Vec::new();
    for chunk in list(&folder.join("data"))?.iter().filter(|chunk| chunk.is_dir()) {
        let is_data = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "parquet");
        files.extend(list(chunk)?.into_iter().filter(is_data));
    }
    Ok(files)
}
