//! Who wins over all scenarios.

use serde::{Deserialize, Serialize};

use super::{
    config::CompareConfig,
    cost::Cost,
    result::{EntryName, NEVER, ScenarioResult, names},
    rounded::rounded,
};

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
            let times_best = rounded((sum / scenarios.len().max(1) as f64).exp());
            Overall {
                entry,
                times_best,
                holds,
                wins,
                cost_ns: cost.map(|cost| rounded(cost.total_ns())),
            }
        })
        .collect();
    all.sort_by(|a, b| a.times_best.total_cmp(&b.times_best));
    all
}

/// The score of an entry that finds nothing.
fn nothing_found(scenario: &ScenarioResult) -> f64 {
    let largest = scenario.faults.iter().map(|fault| fault.relative(fault.largest()).ln());
    let count = scenario.faults.len().max(1) as f64;
    NEVER * (largest.sum::<f64>() / count).exp()
}
