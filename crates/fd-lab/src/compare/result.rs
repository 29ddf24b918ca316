//! What came out: counts of all engines together, and who wins where.

use fd_numeric::median;
use serde::{Deserialize, Serialize};

use super::{
    config::CompareConfig,
    fault::FaultKind,
    rounded::rounded,
    scene::Scene,
    share::Share,
    tally::{Alarms, Outcome, Unit},
};

/// A fault that is never found counts as this many times the largest that was tried.
pub(super) const NEVER: f64 = 2.0;

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

/// A scenario with its entries.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScenarioResult {
    /// Name.
    pub name: String,
    /// What it is meant to show.
    pub about: String,
    /// Names of the outputs, in the order of the confusion matrices.
    pub outputs: Vec<String>,
    /// The faults that were to be found.
    pub faults: Vec<FaultKind>,
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
    /// The same of the lower and of the upper ends of the intervals of all kinds: wider than the
    /// interval of the mean, as if all kinds erred to the same side.
    pub score_interval: [f64; 2],
    /// Runs without an injected fault that alarm. In a scenario with a fault that was there before,
    /// these are the runs in which *that* is seen.
    pub false_alarms: Share,
    /// Whether the wanted rate lies within or above the exact interval of the false alarms on these very
    /// engines, their runs taken as independent. The interval for engines in general is wider, and would
    /// let an entry win that alarms all the time on some of them.
    pub holds: bool,
    /// Runs of each fault of each size that have no alarm without the fault.
    pub looked: u64,
    /// Every kind of fault, in the order of the scenario.
    pub faults: Vec<FaultResult>,
    /// Receiver operating characteristic: for each rate the false alarms and the share of all faults
    /// found.
    pub roc: Vec<RocPoint>,
    /// Which sensor is broken; none for residuals of one channel.
    pub isolation: Option<IsolationResult>,
    /// Test engines on which it could not be built, or had no answer in a fault-free run.
    pub failed_engines: u64,
    /// The same of the engines that set the thresholds: its threshold is that of the others.
    #[serde(default)]
    pub failed_threshold_engines: u64,
}

/// A kind of fault as an entry finds it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FaultResult {
    /// Smallest size that is found in half of the runs; none if no size that was tried is.
    pub smallest: Option<f64>,
    /// Its interval from those of the shares; none where it is beyond the sizes tried.
    pub interval: [Option<f64>; 2],
    /// For each size the runs in which it is found.
    pub found: Vec<u64>,
    /// For each size the median delay in s from the start of the fault, over the runs in which it is
    /// found.
    pub delays_s: Vec<Option<f64>>,
}

/// A point of the receiver operating characteristic.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RocPoint {
    /// Rate of false alarms that the threshold was set for.
    pub rate: f64,
    /// Share of the fault-free test runs that alarm.
    pub false_alarms: f64,
    /// Share of the faults of all kinds and sizes that are found.
    pub found: f64,
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
    pub(super) fn of(scene: &Scene<'_>, thresholds: &[&Unit], tests: &[&Unit]) -> Self {
        let (config, kinds) = (scene.config, &scene.kinds);
        let scenario = &config.scenarios[scene.index];
        let (mut entries, mut failed) = (Vec::new(), Vec::new());
        for (i, entry) in names(config).into_iter().enumerate() {
            let alarms = tests.iter().filter_map(|unit| match &unit.entries[i] {
                Outcome::Alarms(alarms) => Some(alarms),
                Outcome::Failed(_) | Outcome::Peaks(_) => None,
            });
            let engines: Vec<&Alarms> = alarms.collect();
            let failures = |units: &[&Unit]| {
                let failed = |unit: &&&Unit| matches!(unit.entries[i], Outcome::Failed(_));
                units.iter().filter(failed).count() as u64
            };
            if engines.is_empty() {
                // What kept a threshold from being set says more than that there is none.
                let why = thresholds.iter().chain(tests).find_map(|unit| match &unit.entries[i] {
                    Outcome::Failed(why) => Some(why.clone()),
                    _ => None,
                });
                failed.push((entry, why.unwrap_or_else(|| "no engine ran".to_owned())));
            } else {
                let present = scenario.present.is_some();
                let mut result = EntryResult::of(config, entry, kinds, &engines, present);
                result.failed_engines = failures(tests);
                result.failed_threshold_engines = failures(thresholds);
                entries.push(result);
            }
        }
        entries.sort_by(|a, b| b.holds.cmp(&a.holds).then(a.score.total_cmp(&b.score)));
        Self {
            name: scenario.name.clone(),
            about: scenario.about.clone(),
            outputs: scene.outputs(),
            faults: kinds.clone(),
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
        engines: &[&Alarms],
        present: bool,
    ) -> Self {
        let rates = config.rates();
        let faults: Vec<FaultResult> = (0..kinds.len())
            .map(|kind| FaultResult::of(kinds, kind, engines, config.sample_time_s))
            .collect();
        let mean = |size: fn(&FaultResult) -> Option<f64>| {
            let logs = faults.iter().zip(kinds).map(|(fault, kind)| {
                kind.relative(size(fault).unwrap_or(NEVER * kind.largest())).ln()
            });
            rounded((logs.sum::<f64>() / faults.len().max(1) as f64).exp())
        };
        let alarms = |level: usize| -> Vec<(u64, u64)> {
            engines.iter().map(|engine| (engine.healthy[level], engine.healthy_runs)).collect()
        };
        let false_alarms = Share::clustered(&alarms(0));
        let on_these = Share::new(false_alarms.hits, false_alarms.of);
        let levels = engines.first().map_or(0, |engine| engine.roc.len());
        let roc = (0..levels).map(|level| {
            let (healthy, with_fault) = (
                total(alarms(level)),
                total(engines.iter().map(|e| {
                    let (looked, found) = e.roc[level];
                    (found, looked)
                })),
            );
            let [false_alarms, found] = [healthy, with_fault].map(|share| rounded(share.share()));
            RocPoint { rate: rates[level], false_alarms, found }
        });
        Self {
            entry,
            score: mean(|fault| fault.smallest),
            score_interval: [mean(|f| f.interval[0]), mean(|f| f.interval[1])],
            false_alarms,
            holds: present || on_these.low <= config.false_alarms,
            looked: engines.iter().filter_map(|e| Some(e.faults.first()?.first()?.looked)).sum(),
            faults,
            roc: roc.collect(),
            isolation: IsolationResult::of(engines),
            failed_engines: 0,
            failed_threshold_engines: 0,
        }
    }

    /// Share of the runs in which a fault of this kind and size is found.
    #[must_use]
    pub fn found(&self, kind: usize, size: usize) -> f64 {
        self.faults[kind].found[size] as f64 / self.looked as f64
    }
}

/// All engines as if their runs were independent.
fn total(engines: impl IntoIterator<Item = (u64, u64)>) -> Share {
    let (hits, of) = engines.into_iter().fold((0, 0), |sum, e| (sum.0 + e.0, sum.1 + e.1));
    Share::new(hits, of)
}

impl FaultResult {
    fn of(kinds: &[FaultKind], kind: usize, engines: &[&Alarms], ts: f64) -> Self {
        let sizes = &kinds[kind].sizes;
        let of_size = |size: usize| engines.iter().map(move |engine| &engine.faults[kind][size]);
        let shares: Vec<Share> = (0..sizes.len())
            .map(|size| {
                let found = of_size(size).map(|found| (found.delays.len() as u64, found.looked));
                Share::clustered(&found.collect::<Vec<_>>())
            })
            .collect();
        let delay = |size: usize| {
            let delays = of_size(size).flat_map(|found| &found.delays);
            let mut delays: Vec<f64> = delays.map(|&samples| f64::from(samples) * ts).collect();
            (!delays.is_empty()).then(|| rounded(median(&mut delays)))
        };
        let reached = |share: fn(&Share) -> f64| {
            half_way(sizes.iter().zip(&shares).map(|(&size, found)| (size, share(found))))
                .map(rounded)
        };
        Self {
            smallest: reached(Share::share),
            interval: [reached(|found| found.high), reached(|found| found.low)],
            found: shares.iter().map(|found| found.hits).collect(),
            delays_s: (0..sizes.len()).map(delay).collect(),
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
    fn of(engines: &[&Alarms]) -> Option<Self> {
        let right = |confusion: &[Vec<u64>]| (0..confusion.len()).map(|i| confusion[i][i]).sum();
        let all = |confusion: &[Vec<u64>]| confusion.iter().flatten().sum::<u64>();
        let of_engine = |engine: &&Alarms| (right(&engine.confusion), all(&engine.confusion));
        let accuracy = Share::clustered(&engines.iter().map(of_engine).collect::<Vec<_>>());
        let mut confusion = engines.first()?.confusion.clone();
        engines[1..].iter().for_each(|engine| add_all(&mut confusion, &engine.confusion));
        let (right, total) = (accuracy.hits, accuracy.of);
        if total == 0 {
            return None;
        }
        let n = total as f64;
        let by_chance: f64 = (0..confusion.len())
            .map(|i| {
                let truly: u64 = confusion[i].iter().sum();
                let named: u64 = confusion.iter().map(|row| row[i]).sum();
                truly as f64 * named as f64 / (n * n)
            })
            .sum();
        let kappa = (right as f64 / n - by_chance) / (1.0 - by_chance);
        Some(Self { accuracy, kappa: kappa.is_finite().then_some(rounded(kappa)), confusion })
    }
}

fn add_all(sums: &mut [Vec<u64>], more: &[Vec<u64>]) {
    for (sum, more) in sums.iter_mut().flatten().zip(more.iter().flatten()) {
        *sum += more;
    }
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
        format!("{} · {} · {}", self.generator, self.bias, self.detector)
    }
}
