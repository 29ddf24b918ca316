//! What came out: counts of all engines together, and who wins where.

use serde::{Deserialize, Serialize};

use super::{
    config::CompareConfig,
    cost::Cost,
    fault::{FaultKind, ProfileKind},
    scene::Scene,
    share::Share,
    tally::{Alarms, Outcome, Unit},
};
use crate::quantile::median;

/// The version of the JSON report.
pub const REPORT_VERSION: u32 = 1;

/// A fault that is never found counts as this many times the largest that was tried.
const NEVER: f64 = 2.0;

/// The result of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// Version of this schema.
    pub version: u32,
    /// What was compared.
    pub config: CompareConfig,
    /// Rates of false alarms per run behind the ROC, the wanted one first.
    pub rates: Vec<f64>,
    /// All entries over all scenarios, the best first.
    pub overall: Vec<Overall>,
    /// Every scenario with its entries, the best first.
    pub scenarios: Vec<ScenarioResult>,
}

/// Names of what an entry is made of.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct EntryName {
    /// Residual generator.
    pub generator: String,
    /// Bias model.
    pub bias: String,
    /// Detector.
    pub detector: String,
}

/// An entry over all scenarios.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Overall {
    /// The entry.
    pub entry: EntryName,
    /// Its smallest faults relative to those of the best entry of each scenario, geometric mean; a
    /// scenario in which it fails or does not hold its rate of false alarms counts as if it found
    /// nothing.
    pub times_best: f64,
    /// Scenarios in which it could be built and holds its rate of false alarms.
    pub holds: usize,
    /// Scenarios in which it is the best.
    pub wins: usize,
    /// Time per sample in ns on one core.
    pub cost_ns: Option<f64>,
}

/// A scenario with its entries.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScenarioResult {
    /// Name.
    pub name: String,
    /// What it is meant to show.
    pub about: String,
    /// Names of the outputs, in the order of the confusion matrices.
    pub outputs: Vec<String>,
    /// Entries, the best first.
    pub entries: Vec<EntryResult>,
    /// Entries that could not be built, with the reason of the first engine.
    pub failed: Vec<(EntryName, String)>,
}

/// An entry in a scenario.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EntryResult {
    /// The entry.
    pub entry: EntryName,
    /// Smallest faults of all kinds, geometric mean; one that is never found counts as twice the
    /// largest tried.
    pub score: f64,
    /// Runs without an injected fault that alarm. In a scenario with a fault that was there before,
    /// these are the runs in which *that* is seen.
    pub false_alarms: Share,
    /// Whether the wanted rate lies within or above the interval of the false alarms.
    pub holds: bool,
    /// Every kind of fault.
    pub faults: Vec<FaultResult>,
    /// Receiver operating characteristic: for each rate the false alarms and the share of all faults
    /// found.
    pub roc: Vec<RocPoint>,
    /// Which sensor is broken; none for residuals of one channel.
    pub isolation: Option<IsolationResult>,
    /// Test engines on which it could not be built.
    pub failed_engines: u64,
}

/// A kind of fault as an entry finds it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FaultResult {
    /// Place.
    pub site: String,
    /// Development.
    pub profile: ProfileKind,
    /// Smallest size that is found in half of the runs; none if no size that was tried is.
    pub smallest: Option<f64>,
    /// Its interval from those of the shares; none where it is beyond the sizes tried.
    pub interval: [Option<f64>; 2],
    /// Every size.
    pub sizes: Vec<SizeResult>,
}

/// One size of a fault.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SizeResult {
    /// The size, a share of the reading or of the component's parameter.
    pub size: f64,
    /// Runs in which it is found.
    pub found: Share,
    /// Median delay in s from the start of the fault, over the runs in which it is found.
    pub delay_s: Option<f64>,
}

/// A point of the receiver operating characteristic.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RocPoint {
    /// Rate of false alarms that the threshold was set for.
    pub rate: f64,
    /// Rate in the test runs.
    pub false_alarms: Share,
    /// Faults of all kinds and sizes that are found.
    pub found: Share,
}

/// Which sensor is broken.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct IsolationResult {
    /// Found sensor faults that are ascribed to the right sensor.
    pub accuracy: Share,
    /// Cohen's kappa: 1 for always right, 0 for as good as chance; none when nothing was found.
    pub kappa: Option<f64>,
    /// Runs by true and by named sensor, in the order of the outputs.
    pub confusion: Vec<Vec<u64>>,
}

/// Threshold factors of each entry, one per rate; none for an entry that failed.
pub(super) fn factors(config: &CompareConfig, units: &[&Unit]) -> Vec<Vec<f64>> {
    let rates = config.rates();
    (0..config.entries())
        .map(|entry| {
            let mut peaks: Vec<f64> = Vec::new();
            for unit in units {
                if let Some(Outcome::Peaks(more)) = unit.entries.get(entry) {
                    peaks.extend_from_slice(more);
                }
            }
            peaks.sort_unstable_by(|a, b| b.total_cmp(a));
            // The k-th largest of n is exceeded by a further run with probability k / (n + 1).
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below n")]
            let place = |rate: f64| (rate * (peaks.len() + 1) as f64 + 1e-9).floor() as usize;
            rates
                .iter()
                .map_while(|&rate| peaks.get(place(rate).checked_sub(1)?).copied())
                .collect()
        })
        .collect()
}

impl ScenarioResult {
    pub(super) fn of(scene: &Scene<'_>, units: &[&Unit]) -> Self {
        let (config, kinds) = (scene.config, &scene.kinds);
        let scenario = &config.scenarios[scene.index];
        let (mut entries, mut failed) = (Vec::new(), Vec::new());
        for (i, entry) in names(config).into_iter().enumerate() {
            let mut sum: Option<Alarms> = None;
            let (mut failed_engines, mut reason) = (0, None);
            for unit in units {
                match &unit.entries[i] {
                    Outcome::Alarms(alarms) => match &mut sum {
                        Some(sum) => sum.add(alarms),
                        None => sum = Some(alarms.clone()),
                    },
                    Outcome::Failed(why) => {
                        failed_engines += 1;
                        reason.get_or_insert_with(|| why.clone());
                    }
                    Outcome::Peaks(_) => {}
                }
            }
            match sum {
                Some(sum) => {
                    let present = scenario.present.is_some();
                    let mut result = EntryResult::of(config, entry, kinds, &sum, present);
                    result.failed_engines = failed_engines;
                    entries.push(result);
                }
                None => failed.push((entry, reason.unwrap_or_else(|| "no engine ran".to_owned()))),
            }
        }
        entries.sort_by(|a, b| b.holds.cmp(&a.holds).then(a.score.total_cmp(&b.score)));
        Self {
            name: scenario.name.clone(),
            about: scenario.about.clone(),
            outputs: scene.outputs(),
            entries,
            failed,
        }
    }
}

impl EntryResult {
    fn of(
        config: &CompareConfig,
        entry: EntryName,
        kinds: &[FaultKind],
        sum: &Alarms,
        present: bool,
    ) -> Self {
        let rates = config.rates();
        let ts = config.sample_time_s;
        let faults: Vec<FaultResult> = kinds
            .iter()
            .zip(&sum.faults)
            .map(|(kind, found)| FaultResult::of(kind, found, ts))
            .collect();
        let logs = faults.iter().zip(kinds).map(|(fault, kind)| {
            let never = NEVER * kind.sizes.last().copied().unwrap_or(f64::NAN);
            fault.smallest.unwrap_or(never).ln()
        });
        let score = (logs.sum::<f64>() / faults.len().max(1) as f64).exp();
        let alarms = |level: usize| Share::new(sum.healthy[level], sum.healthy_runs);
        let false_alarms = alarms(0);
        let roc = (0..sum.roc.len()).map(|level| RocPoint {
            rate: rates[level],
            false_alarms: alarms(level),
            found: Share::new(sum.roc[level].1, sum.roc[level].0),
        });
        Self {
            entry,
            score,
            false_alarms,
            holds: present || false_alarms.low <= config.false_alarms,
            faults,
            roc: roc.collect(),
            isolation: IsolationResult::of(&sum.confusion),
            failed_engines: 0,
        }
    }
}

impl FaultResult {
    fn of(kind: &FaultKind, found: &[super::tally::Found], ts: f64) -> Self {
        let sizes: Vec<SizeResult> = kind
            .sizes
            .iter()
            .zip(found)
            .map(|(&size, found)| {
                let mut delays: Vec<f64> =
                    found.delays.iter().map(|&samples| f64::from(samples) * ts).collect();
                SizeResult {
                    size,
                    found: Share::new(delays.len() as u64, found.looked),
                    delay_s: (!delays.is_empty()).then(|| median(&mut delays)),
                }
            })
            .collect();
        let reached = |share: fn(&Share) -> f64| {
            half_way(sizes.iter().map(|size| (size.size, share(&size.found))))
        };
        Self {
            site: kind.site.target().to_string(),
            profile: kind.profile,
            smallest: reached(|found| found.share),
            interval: [reached(|found| found.high), reached(|found| found.low)],
            sizes,
        }
    }
}

/// Where a share that should rise with size passes one half, interpolated in the logarithm of the
/// size; the smallest size if it is above from the beginning.
fn half_way(points: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let mut before: Option<(f64, f64)> = None;
    for (size, share) in points {
        if share >= 0.5 {
            return Some(match before {
                Some((smaller, less)) => {
                    let part = (0.5 - less) / (share - less);
                    smaller * (size / smaller).powf(part)
                }
                None => size,
            });
        }
        before = Some((size, share));
    }
    None
}

impl IsolationResult {
    fn of(confusion: &[Vec<u64>]) -> Option<Self> {
        let total: u64 = confusion.iter().flatten().sum();
        if total == 0 {
            return None;
        }
        let right: u64 = (0..confusion.len()).map(|i| confusion[i][i]).sum();
        let n = total as f64;
        let by_chance: f64 = (0..confusion.len())
            .map(|i| {
                let truly: u64 = confusion[i].iter().sum();
                let named: u64 = confusion.iter().map(|row| row[i]).sum();
                truly as f64 * named as f64 / (n * n)
            })
            .sum();
        let kappa = (right as f64 / n - by_chance) / (1.0 - by_chance);
        Some(Self {
            accuracy: Share::new(right, total),
            kappa: kappa.is_finite().then_some(kappa),
            confusion: confusion.to_vec(),
        })
    }
}

/// All entries over all scenarios, the best first.
pub(super) fn overall(
    config: &CompareConfig,
    scenarios: &[ScenarioResult],
    costs: &[Option<Cost>],
) -> Vec<Overall> {
    let mut all: Vec<Overall> = names(config)
        .into_iter()
        .zip(costs)
        .map(|(entry, cost)| {
            let (mut sum, mut holds, mut wins) = (0.0, 0, 0);
            for scenario in scenarios {
                let best = scenario.entries.first().map_or(f64::NAN, |best| best.score);
                let own = scenario.entries.iter().position(|result| result.entry == entry);
                let own = own.filter(|&i| scenario.entries[i].holds);
                holds += usize::from(own.is_some());
                wins += usize::from(own == Some(0));
                let score =
                    own.map_or_else(|| nothing_found(scenario), |i| scenario.entries[i].score);
                sum += (score / best).ln();
            }
            let times_best = (sum / scenarios.len().max(1) as f64).exp();
            Overall { entry, times_best, holds, wins, cost_ns: cost.map(Cost::total_ns) }
        })
        .collect();
    all.sort_by(|a, b| a.times_best.total_cmp(&b.times_best));
    all
}

/// The score of an entry that finds nothing.
fn nothing_found(scenario: &ScenarioResult) -> f64 {
    let faults = scenario.entries.first().map_or(&[][..], |entry| &entry.faults);
    let largest = faults.iter().filter_map(|fault| fault.sizes.last()).map(|size| size.size.ln());
    let count = faults.len().max(1) as f64;
    NEVER * (largest.sum::<f64>() / count).exp()
}

/// The entries in the order of their outcomes.
pub(super) fn names(config: &CompareConfig) -> Vec<EntryName> {
    let mut names = Vec::with_capacity(config.entries());
    for generator in &config.generators {
        for bias in &config.biases {
            for detector in &config.detectors {
                names.push(EntryName {
                    generator: generator.name.clone(),
                    bias: bias.name.clone(),
                    detector: detector.name.clone(),
                });
            }
        }
    }
    names
}

impl EntryName {
    /// In one line.
    #[must_use]
    pub fn text(&self) -> String {
        format!("{} | {} | {}", self.generator, self.bias, self.detector)
    }
}
