//! The comparison as a page of text that can be kept next to the code.

use fd_model::figure;
use fd_report::{Table, markdown_text};

use super::{
    comparison::Comparison,
    config::CompareConfig,
    family::Family,
    report::{SHOWN, percent},
    result::{EntryResult, ScenarioResult},
};

/// Entries shown of each scenario.
const BEST: usize = 5;
/// Size of a fault at which delays are compared, as far as it was tried.
const COMMON_SIZE: f64 = 0.01;

impl Comparison {
    /// The result as Markdown; `command` is what it was made with.
    #[must_use]
    pub fn markdown(&self, command: &str) -> String {
        let mut parts = vec![
            "# Comparison of methods".to_owned(),
            markdown_text(&self.headline()),
            format!(
                "Written by `{command}`, version {} of `fdiag`. How it is counted, and what to choose: \
                 [compare.md](../compare.md).",
                env!("CARGO_PKG_VERSION"),
                command = command.replace('`', "'").replace(char::is_control, " "),
            ),
            self.counts(),
        ];
        let mut section = |heading: &str, text: &str, table: &Table| {
            let filled = [heading, text, table.to_markdown().trim_end()].map(str::to_owned);
            parts.extend(filled.into_iter().filter(|part| !part.is_empty()));
        };
        section(
            "## All scenarios",
            "Times the smallest faults of the best entry of each scenario, geometric mean; an entry that \
             does not keep its rate in a scenario, or cannot be built, counts there as if it found \
             nothing.",
            &self.overall_table(SHOWN),
        );
        section("## The best entry with each part", "", &self.by_part());
        section(
            "## Ways to be robust",
            "Smallest fault in per cent (of the reading; where sizes have units, of the largest size that was tried), \
             geometric mean over all kinds, of the best entry of each family \
             that keeps its rate (`!`: none does), with the geometric means of the ends of the intervals. \
             Which entry is the best is decided by these same numbers, which flatters it a little.",
            &self.by_family(),
        );
        section("### Their best entries", &self.common_size(), &self.family_entries());
        for scenario in &self.scenarios {
            section(
                &format!("## {}", markdown_text(&scenario.name)),
                &format!(
                    "{}. Smallest fault with its interval; the best {BEST} of {} entries.{}",
                    markdown_text(&scenario.about),
                    scenario.entries.len(),
                    scenario
                        .left_out(self.config.engines)
                        .map_or_else(String::new, |s| format!(" {s}")),
                ),
                &scenario.best(),
            );
        }
        parts.join("\n\n") + "\n"
    }

    /// How many engines and runs are behind the numbers.
    fn counts(&self) -> String {
        let CompareConfig { engines, false_alarms, first_seed, .. } = &self.config;
        format!(
            "{} engines, from seed {first_seed} on, set the thresholds for {} % of fault-free runs with \
             an alarm ({} runs), {} others are counted: {} fault-free runs, and {} runs for each fault \
             of each size. Intervals are of 95 %.",
            engines.thresholds,
            figure(100.0 * false_alarms),
            engines.thresholds * engines.threshold_runs,
            engines.test,
            engines.test * engines.test_runs,
            engines.test * engines.fault_runs,
        )
    }

    fn common_size(&self) -> String {
        let sizes: Vec<String> = self.scenarios.first().map_or_else(Vec::new, |scenario| {
            let common = |kind: usize| scenario.common_size(kind);
            let named = scenario.faults.iter().enumerate();
            named
                .map(|(k, kind)| {
                    format!("{} {} {}", kind.name(), kind.shown(kind.sizes[common(k)]), kind.unit())
                })
                .collect()
        });
        format!(
            "The delay is the mean over the kinds of faults of the median delay in s for a fault near \
             {} % (in the first scenario: {}); `-` where a kind is never found at that size.",
            percent(COMMON_SIZE),
            sizes.join(", "),
        )
    }

    /// The best entry of a family in a scenario.
    fn best_of<'a>(&self, scenario: &'a ScenarioResult, family: Family) -> Option<&'a EntryResult> {
        let is_of = |entry: &&EntryResult| self.config.family(&entry.entry) == Some(family);
        scenario.entries.iter().find(is_of)
    }

    fn by_family(&self) -> Table {
        let header: Vec<&str> =
            ["scenario"].into_iter().chain(Family::ALL.map(Family::name)).collect();
        let mut table = Table::new("Smallest fault of each family [%]", &header);
        for scenario in &self.scenarios {
            let cell = |family| {
                let best = self.best_of(scenario, family);
                best.map_or_else(|| "-".to_owned(), EntryResult::smallest)
            };
            table.push([scenario.name.clone()].into_iter().chain(Family::ALL.map(cell)));
        }
        table
    }

    fn family_entries(&self) -> Table {
        let mut table = Table::new(
            "The best entry of each family",
            &[
                "scenario",
                "family",
                "entry",
                "runs with an alarm, fault-free [%]",
                "delay [s]",
                "right sensor [%]",
                "kappa",
                "ns per sample",
            ],
        );
        for scenario in &self.scenarios {
            for family in Family::ALL {
                let Some(best) = self.best_of(scenario, family) else { continue };
                let cost = self.overall.iter().find(|o| o.entry == best.entry);
                let [right, kappa] = best.isolated();
                table.push([
                    scenario.name.clone(),
                    family.name().to_owned(),
                    best.entry.text(),
                    best.alarms(),
                    scenario.delay(best).map_or_else(|| "-".to_owned(), figure),
                    right,
                    kappa,
                    cost.and_then(|o| o.cost_ns).map_or_else(|| "-".to_owned(), figure),
                ]);
            }
        }
        table
    }
}

impl ScenarioResult {
    fn best(&self) -> Table {
        let mut header =
            vec!["entry", "runs with an alarm, fault-free [%]", "right sensor [%]", "kappa"];
        let kinds: Vec<String> = self.faults.iter().map(super::FaultKind::heading).collect();
        header.extend(kinds.iter().map(String::as_str));
        let mut table = Table::new(self.name.clone(), &header);
        for entry in self.entries.iter().take(BEST) {
            let faults = entry.faults.iter().zip(&self.faults).map(|(fault, kind)| {
                let Some(smallest) = fault.smallest else { return kind.beyond() };
                let end =
                    |end: Option<f64>| end.map_or_else(|| kind.beyond(), |size| kind.shown(size));
                let [low, high] = fault.interval.map(end);
                format!("{} [{low} .. {high}]", kind.shown(smallest))
            });
            let head = [entry.entry.text(), entry.alarms()].into_iter().chain(entry.isolated());
            table.push(head.chain(faults).collect::<Vec<_>>());
        }
        table
    }

    /// Index of the size of a kind of fault that is nearest to the common one.
    fn common_size(&self, kind: usize) -> usize {
        let kind = &self.faults[kind];
        let away = |size: f64| (kind.relative(size) / COMMON_SIZE).ln().abs();
        let sizes = kind.sizes.iter().enumerate();
        sizes.min_by(|a, b| away(*a.1).total_cmp(&away(*b.1))).map_or(0, |(at, _)| at)
    }

    /// Mean over the kinds of faults of the median delay at the common size.
    fn delay(&self, entry: &EntryResult) -> Option<f64> {
        let delays = entry.faults.iter().enumerate();
        let sum: Option<f64> = delays.map(|(k, f)| f.delays_s[self.common_size(k)]).sum();
        Some(sum? / self.faults.len() as f64)
    }
}

impl EntryResult {
    /// The smallest faults with their interval, marked where the rate of false alarms is not kept.
    fn smallest(&self) -> String {
        let [low, high] = self.score_interval.map(percent);
        let mark = if self.holds { "" } else { " !" };
        format!("{} [{low} .. {high}]{mark}", percent(self.score))
    }

    fn alarms(&self) -> String {
        self.false_alarms.text() + if self.holds { "" } else { " !" }
    }
}
