//! The comparison as a sentence, tables, pictures and a page.

use fd_model::figure;
use fd_report::{Bar, Bars, Line, Page, Picture, PictureError, Shares, Table};

use super::{
    comparison::Comparison,
    config::Engines,
    overall::Overall,
    result::{EntryResult, ScenarioResult},
};

/// Entries shown of all; the rest is in the JSON.
pub(super) const SHOWN: usize = 12;
/// Lines in a picture.
const LINES: usize = 5;

/// The name of one part of an entry.
type Part = fn(&Overall) -> &String;

/// Shorter is better, so the bar shows the part of the best that is reached.
fn bar(overall: &Overall) -> Bar {
    Bar::new(overall.entry.text(), 1.0 / overall.times_best, figure(overall.times_best))
}

impl Comparison {
    /// What came out, in one sentence.
    #[must_use]
    pub fn headline(&self) -> String {
        let scenarios = self.scenarios.len();
        let Some(best) = self.overall.first() else { return "Nothing was compared.".to_owned() };
        let text = format!(
            "Over {scenarios} scenarios `{}` finds the smallest faults at {} % false alarms per run: \
             {} times those of the best of each scenario, and it keeps its rate in {} of them.",
            best.entry.text(),
            figure(100.0 * self.config.false_alarms),
            figure(best.times_best),
            best.holds,
        );
        if let Some(plain) = self.best_without_bias_model()
            && plain.entry != best.entry
        {
            let times = figure(plain.times_best / best.times_best);
            let entry = plain.entry.text();
            return format!(
                "{text} Without compensation the best, `{entry}`, needs {times} times larger faults."
            );
        }
        text
    }

    fn best_without_bias_model(&self) -> Option<&Overall> {
        self.overall.iter().find(|overall| self.is_plain(&overall.entry.bias))
    }

    /// The result as tables for a terminal; the page has more.
    #[must_use]
    pub fn tables(&self) -> Vec<Table> {
        vec![self.overall_table(SHOWN), self.by_part(), self.by_scenario()]
    }

    /// The best entry of each scenario, and what it gains over the best without compensation.
    fn by_scenario(&self) -> Table {
        let mut table = Table::new(
            "The best entry of each scenario",
            &["scenario", "entry", "smallest fault [%]", "without bias model", "false alarms [%]"],
        );
        for scenario in &self.scenarios {
            let Some(best) = scenario.entries.first() else {
                table.push([scenario.name.as_str(), "none could be built", "-", "-", "-"]);
                continue;
            };
            let plain = scenario.entries.iter().find(|entry| self.is_plain(&entry.entry.bias));
            table.push([
                scenario.name.clone(),
                best.entry.text(),
                percent(best.score),
                plain.map_or_else(|| "-".to_owned(), |plain| percent(plain.score)),
                best.false_alarms.text(),
            ]);
        }
        table
    }

    fn is_plain(&self, bias: &str) -> bool {
        self.config.biases.iter().any(|known| known.name == bias && known.spec.is_none())
    }

    pub(super) fn overall_table(&self, rows: usize) -> Table {
        let mut table = Table::new(
            format!(
                "All scenarios, best {} of {} entries",
                rows.min(self.overall.len()),
                self.overall.len()
            ),
            &["generator · bias · detector", "times best", "keeps rate", "wins", "ns/sample"],
        );
        for overall in self.overall.iter().take(rows) {
            table.push([
                overall.entry.text(),
                figure(overall.times_best),
                format!("{} of {}", overall.holds, self.scenarios.len()),
                overall.wins.to_string(),
                overall.cost_ns.map_or_else(|| "-".to_owned(), figure),
            ]);
        }
        table
    }

    /// The result as a page.
    ///
    /// # Errors
    ///
    /// Returns an error when a picture cannot be drawn.
    pub fn page(&self) -> Result<Page, PictureError> {
        let mut page = Page::new("Comparison of diagnoses", self.headline());
        page.heading("All scenarios");
        page.text(
            "How much larger a fault must be than the smallest that any entry finds, in the geometric \
             mean over scenarios and faults. An entry that alarms more often than it may in a \
             scenario, or cannot be built there, counts as if it found nothing.",
        );
        page.bars(Bars {
            bars: self.overall.iter().take(SHOWN).map(bar).collect(),
            ..Bars::default()
        });
        page.table(self.overall_table(SHOWN));
        page.table(self.by_part());
        page.table(self.by_scenario());
        for scenario in &self.scenarios {
            scenario.section(&mut page, self.config.engines)?;
        }
        Ok(page)
    }

    /// The best entry with each part, so that one sees what each part is worth.
    pub(super) fn by_part(&self) -> Table {
        let mut table =
            Table::new("The best entry with each part", &["part", "name", "times best", "with"]);
        let parts: [(&str, Part, Vec<&String>); 3] = [
            (
                "generator",
                |o| &o.entry.generator,
                self.config.generators.iter().map(|g| &g.name).collect(),
            ),
            ("bias", |o| &o.entry.bias, self.config.biases.iter().map(|b| &b.name).collect()),
            (
                "detector",
                |o| &o.entry.detector,
                self.config.detectors.iter().map(|d| &d.name).collect(),
            ),
        ];
        for (kind, part, names) in parts {
            for name in names {
                if let Some(best) = self.overall.iter().find(|overall| part(overall) == name) {
                    table.push([
                        kind.to_owned(),
                        name.clone(),
                        figure(best.times_best),
                        best.entry.text(),
                    ]);
                }
            }
        }
        table
    }
}

impl ScenarioResult {
    fn table(&self, rows: usize) -> Table {
        let mut header = vec!["entry", "false alarms [%]", "isolated [%]", "kappa"];
        let kinds: Vec<String> = self.faults.iter().map(super::FaultKind::heading).collect();
        header.extend(kinds.iter().map(String::as_str));
        let mut table = Table::new(
            format!("{}: {}; smallest fault found in half of the runs", self.name, self.about),
            &header,
        );
        for entry in self.entries.iter().take(rows) {
            let mut alarms = entry.false_alarms.text();
            if !entry.holds {
                alarms += " too many";
            }
            let faults = entry.faults.iter().zip(&self.faults);
            let smallest = faults.map(|(fault, kind)| {
                fault.smallest.map_or_else(|| kind.beyond(), |size| kind.shown(size))
            });
            let head = [entry.entry.text(), alarms].into_iter().chain(entry.isolated());
            table.push(head.chain(smallest));
        }
        table
    }

    /// On how many of the engines entries are not counted, because the plant ran away, there was nothing to build, or the
    /// residual had no value; none where all are.
    pub(super) fn left_out(&self, engines: Engines) -> Option<String> {
        let of = |failed: fn(&EntryResult) -> u64, engines: u64, what: &str| {
            let counts = || self.entries.iter().map(failed);
            let (least, most) = (counts().min()?, counts().max()?);
            let range =
                if least == most { format!("{most}") } else { format!("{least} to {most}") };
            (most > 0).then(|| format!("{range} of the {engines} engines that were to {what}"))
        };
        let tested = of(|entry| entry.failed_engines, engines.test, "be counted");
        let set = of(|entry| entry.failed_threshold_engines, engines.thresholds, "set thresholds");
        let both: Vec<String> = tested.into_iter().chain(set).collect();
        (!both.is_empty()).then(|| {
            format!(
                "Left out: {}, by entry, on which the plant ran away, the entry could not be built or its residual had \
                 no value. Shares, intervals and thresholds are of the others.",
                both.join(", and ")
            )
        })
    }

    fn section(&self, page: &mut Page, engines: Engines) -> Result<(), PictureError> {
        page.heading(self.name.clone());
        if !self.about.is_empty() {
            page.text(self.about.clone());
        }
        if let Some(left_out) = self.left_out(engines) {
            page.text(left_out);
        }
        page.table(self.table(SHOWN));
        let mut chosen: Vec<&EntryResult> = Vec::new();
        // One entry per generator and kind of compensation says more than five that are alike.
        for entry in &self.entries {
            let is_new = chosen.iter().all(|other| {
                other.entry.generator != entry.entry.generator
                    || other.entry.bias != entry.entry.bias
            });
            if is_new && chosen.len() < LINES {
                chosen.push(entry);
            }
        }
        let mut gallery = Vec::new();
        for (k, kind) in self.faults.iter().enumerate() {
            let lines = chosen.iter().map(|entry| {
                let points = kind.sizes.iter().enumerate();
                let points =
                    points.map(|(s, size)| (kind.in_unit(*size), 100.0 * entry.found(k, s)));
                Line::new(entry.entry.text(), points)
            });
            gallery.push((
                Picture {
                    title: kind.name(),
                    x_label: format!("size [{}]", kind.unit()),
                    y_label: "found [% of runs]".to_owned(),
                    log_x: true,
                    lines: lines.collect(),
                    ..Picture::default()
                },
                format!("Faults of {} that are found, by size.", kind.site.target()),
            ));
        }
        let lines = chosen.iter().map(|entry| {
            let points = entry.roc.iter().map(|p| (100.0 * p.false_alarms, 100.0 * p.found));
            let mut points: Vec<(f64, f64)> = points.collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
            Line::new(entry.entry.text(), points)
        });
        gallery.push((
            Picture {
                title: "Receiver operating characteristic".to_owned(),
                x_label: "fault-free runs with an alarm [%]".to_owned(),
                y_label: "faults found [%]".to_owned(),
                lines: lines.collect(),
                ..Picture::default()
            },
            "Faults of all kinds and sizes that are found, against false alarms, for thresholds set for \
             several rates."
                .to_owned(),
        ));
        page.gallery(&gallery)?;
        if let Some((entry, isolation)) =
            self.entries.iter().find_map(|entry| Some((entry, entry.isolation.as_ref()?)))
        {
            page.shares(Shares {
                title: format!("Which sensor is faulty, named by {}", entry.entry.text()),
                corner: "true".to_owned(),
                columns: self.outputs.clone(),
                rows: confusion_shares(&self.outputs, &isolation.confusion),
            });
        }
        if !self.failed.is_empty() {
            let reasons: Vec<String> =
                self.failed.iter().map(|(entry, why)| format!("{}: {why}", entry.text())).collect();
            page.details(
                format!("{} entries that cannot be built", reasons.len()),
                reasons.join("\n"),
            );
        }
        Ok(())
    }
}

/// Rows of true sensors that were faulty, as shares of each row.
fn confusion_shares(outputs: &[String], confusion: &[Vec<u64>]) -> Vec<(String, Vec<f64>)> {
    let rows = outputs.iter().zip(confusion).filter_map(|(output, row)| {
        let total: u64 = row.iter().sum();
        let shares = row.iter().map(|&count| count as f64 / total as f64).collect();
        (total > 0).then(|| (output.clone(), shares))
    });
    rows.collect()
}

pub(super) fn percent(share: f64) -> String {
    figure(100.0 * share)
}

impl EntryResult {
    /// Share of right sensors and kappa.
    pub(super) fn isolated(&self) -> [String; 2] {
        let none = || "-".to_owned();
        let isolation = self.isolation.as_ref();
        [
            isolation.map_or_else(none, |i| percent(i.accuracy.share())),
            isolation.and_then(|i| i.kappa).map_or_else(none, figure),
        ]
    }
}
