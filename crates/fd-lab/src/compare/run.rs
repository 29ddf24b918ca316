//! All engines of all scenarios on all cores, to be continued after an interruption.

use std::path::Path;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{
    comparison::{Comparison, REPORT_VERSION},
    config::CompareConfig,
    error::CompareError,
    file_hash::{FileHash, file_hashes, first_changed},
    overall::overall,
    result::{ScenarioResult, factors},
    scene::Scene,
    tally::{Outcome, Role, Unit},
};
use crate::journal::{Journal, read, restart};
use fdiag::Watcher;

/// A line of the journal.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Line {
    /// What is being compared; the first line.
    Begun(Box<Begun>),
    /// The first line as it once was, without the model files.
    Config(Box<CompareConfig>),
    /// An engine that sets thresholds.
    Thresholds(Unit),
    /// An engine that results are taken from.
    Test(Unit),
}

/// What the finished engines belong to.
#[derive(Serialize, Deserialize)]
struct Begun {
    config: CompareConfig,
    files: Vec<FileHash>,
}

/// Forgets the finished engines in a journal; none is no mistake.
///
/// # Errors
///
/// Returns an error when another run is writing the journal, or it cannot be written.
pub fn begin_anew(journal: &Path) -> Result<(), CompareError> {
    Ok(restart(journal)?)
}

impl Comparison {
    /// Runs a comparison on the threads of the current rayon pool.
    ///
    /// With a journal, engines that were finished by an earlier call with the same configuration and the
    /// same contents of its model files are not run again; with others it is refused. The result, but for
    /// the costs, does not depend on the number of threads nor on interruptions.
    ///
    /// # Errors
    ///
    /// Returns an error when a setting cannot be, an engine does not exist, the journal cannot be
    /// used, or the watcher stops it. Entries that cannot be built, and engines that cannot be run, are listed in the result.
    pub fn run(
        config: &CompareConfig,
        journal: Option<&Path>,
        watcher: &impl Watcher,
    ) -> Result<Self, CompareError> {
        config.check()?;
        let scenes: Vec<Scene<'_>> = (0..config.scenarios.len())
            .map(|index| Scene::new(config, index))
            .collect::<Result<_, _>>()?;
        // Held to the end: two runs must not finish the same engines into the same file.
        let held = journal.map(Journal::open).transpose()?;
        let files = if held.is_some() { file_hashes(config)? } else { Vec::new() };
        let (known_thresholds, known_tests) = known(config, &files, journal)?;
        let journal = held;
        if let Some(journal) = &journal
            && known_thresholds.is_none()
        {
            journal.append(&Line::Begun(Box::new(Begun { config: config.clone(), files })))?;
        }
        let known_thresholds = known_thresholds.unwrap_or_default();
        let engines = config.engines;
        let first = config.first_seed;
        let threshold_seeds: Vec<u64> = (first..first + engines.thresholds).collect();
        let first = first + engines.thresholds;
        let test_seeds: Vec<u64> = (first..first + engines.test).collect();
        let total = scenes.len() as u64 * (engines.thresholds + engines.test);
        watcher.begin(total, (known_thresholds.len() + known_tests.len()) as u64);

        let keep = |line: &Line| journal.as_ref().map_or(Ok(()), |journal| journal.append(line));
        let thresholds = all(&scenes, &threshold_seeds, &known_thresholds, |scene, seed| {
            let unit = unit(scene, seed, Role::Thresholds, watcher)?;
            keep(&Line::Thresholds(unit.clone()))?;
            watcher.advance();
            Ok(unit)
        })?;
        let factors: Vec<Vec<Vec<f64>>> =
            (0..scenes.len()).map(|scenario| factors(config, &of(&thresholds, scenario))).collect();
        let tests = all(&scenes, &test_seeds, &known_tests, |scene, seed| {
            let unit = unit(scene, seed, Role::Test(&factors[scene.index]), watcher)?;
            keep(&Line::Test(unit.clone()))?;
            watcher.advance();
            Ok(unit)
        })?;
        let scenarios: Vec<ScenarioResult> = scenes
            .iter()
            .map(|scene| {
                let [thresholds, tests] = [&thresholds, &tests].map(|units| of(units, scene.index));
                ScenarioResult::of(scene, &thresholds, &tests)
            })
            .collect();
        let costs = scenes[0].costs(test_seeds[0]).unwrap_or_else(|_| vec![None; config.entries()]);
        Ok(Self {
            version: REPORT_VERSION,
            config: config.clone(),
            rates: config.rates(),
            overall: overall(config, &scenarios, &costs),
            scenarios,
        })
    }
}

type Known = (Option<Vec<Unit>>, Vec<Unit>);

/// Engines that were finished before; no thresholds at all means that nothing was begun.
fn known(
    config: &CompareConfig,
    files: &[FileHash],
    journal: Option<&Path>,
) -> Result<Known, CompareError> {
    let Some(path) = journal else { return Ok((None, Vec::new())) };
    let mut lines = read::<Line>(path)?.into_iter();
    match lines.next() {
        None => return Ok((None, Vec::new())),
        Some(Line::Begun(begun)) if begun.config == *config => {
            if let Some(file) = first_changed(&begun.files, files) {
                return Err(CompareError::ChangedFile { journal: path.to_owned(), file });
            }
        }
        Some(_) => return Err(CompareError::OtherRun { journal: path.to_owned() }),
    }
    let (mut thresholds, mut tests) = (Vec::new(), Vec::new());
    for line in lines {
        match line {
            Line::Thresholds(unit) => thresholds.push(unit),
            Line::Test(unit) => tests.push(unit),
            Line::Begun(_) | Line::Config(_) => {
                return Err(CompareError::OtherRun { journal: path.to_owned() });
            }
        }
    }
    Ok((Some(thresholds), tests))
}

/// Every scenario with every seed, in order; what is known is not run.
fn all(
    scenes: &[Scene<'_>],
    seeds: &[u64],
    known: &[Unit],
    run: impl Fn(&Scene<'_>, u64) -> Result<Unit, CompareError> + Sync,
) -> Result<Vec<Unit>, CompareError> {
    let pieces: Vec<(&Scene<'_>, u64)> =
        seeds.iter().flat_map(|&seed| scenes.iter().map(move |scene| (scene, seed))).collect();
    pieces
        .into_par_iter()
        .map(|(scene, seed)| {
            let unit = known.iter().find(|unit| unit.scenario == scene.index && unit.seed == seed);
            unit.map_or_else(|| run(scene, seed), |unit| Ok(unit.clone()))
        })
        .collect()
}

fn of(units: &[Unit], scenario: usize) -> Vec<&Unit> {
    units.iter().filter(|unit| unit.scenario == scenario).collect()
}

/// One engine; if it cannot be run at all, no entry can.
fn unit(
    scene: &Scene<'_>,
    seed: u64,
    role: Role<'_>,
    watcher: &impl Watcher,
) -> Result<Unit, CompareError> {
    match scene.unit(seed, role, watcher) {
        Ok(unit) => Ok(unit),
        Err(CompareError::Stopped) => Err(CompareError::Stopped),
        Err(error) => {
            let failed = Outcome::Failed(error.to_string());
            let entries = vec![failed; scene.config.entries()];
            Ok(Unit { scenario: scene.index, seed, entries })
        }
    }
}
