//! A score as tables, a page and a document.

mod classes;

use std::fmt::Write as _;

use fd_model::figure;
use fd_report::{Line, Page, Picture, PictureError, Table};

use super::{BySquares, Calibration, Rate, Score};

/// Verdicts that a report lists.
const LISTED: usize = 60;

impl Score {
    /// The one sentence.
    #[must_use]
    pub fn headline(&self) -> String {
        if !self.verdicts.iter().any(super::Verdict::is_plain) && !self.classes.is_empty() {
            let names: Vec<&str> = self.classes.iter().map(|class| class.name.as_str()).collect();
            return format!("{} cases of {}", self.cases, names.join(", "));
        }
        format!(
            "{} cases: the right cause, or one that no log could tell from it, came first in {:.1} % \
             of {} visible single effects",
            self.cases,
            100.0 * self.top.share,
            self.top.of
        )
    }

    /// All tables: those of the first kinds of cases, if there are any, then one per class.
    #[must_use]
    pub fn tables(&self) -> Vec<Table> {
        let mut tables = Vec::new();
        if self.classes.is_empty() || self.verdicts.iter().any(super::Verdict::is_plain) {
            tables.extend([
                self.measures(),
                self.by_distance(),
                self.told(),
                self.shares(),
                self.baselines(),
                self.reliability(),
                self.confusion(),
            ]);
        }
        tables.extend(self.classes.iter().map(super::ClassScore::table));
        tables
    }

    fn measures(&self) -> Table {
        let mut table = Table::new("Measures", &["measure", "result", "target"]);
        let mut row = |what: &str, result: String, target: &str| {
            table.push([what.to_owned(), result, target.to_owned()]);
        };
        row("right cause first (or inseparable), visible single effects", self.top.text(), ".95");
        row("  with white noise", self.top_by_noise[0].text(), "");
        row("  with AR(.8) noise", self.top_by_noise[1].text(), "");
        row("  very label and site", self.strict_top.text(), "");
        row("  mechanism and place", self.place[0].text(), "");
        row("  side", self.place[1].text(), "");
        row("one cause named: precision at the most sure 60 %", self.precision.text(), ".98");
        row("  named alone with p > .9", self.sure[0].text(), "");
        row("  precision of these", self.sure[1].text(), "");
        row("no gap, blamed with p > .5: white noise", self.blamed[0].text(), ".03");
        row("no gap, blamed with p > .5: AR(.8) noise", self.blamed[1].text(), ".05");
        row("withheld class told at 3 % false abstention", self.withheld.text(), ".70");
        row("  told by the diagnosis itself", self.withheld_own[0].text(), "");
        row("  its false abstentions", self.withheld_own[1].text(), "");
        row("  withheld, but mimicked by one known effect", self.mimicked.text(), "");
        let errors = |c: &[Calibration; 2]| format!("{:.3} / {:.3}", c[0].error, c[1].error);
        row("calibration error of groups: matched / mismatch", errors(&self.group), ".06 / .12");
        row("calibration error of labels: matched / mismatch", errors(&self.label), "");
        row("law mismatch: label", self.mismatch[0].text(), ".65");
        row("law mismatch: mechanism and place", self.mismatch[1].text(), ".80");
        row("law mismatch: side", self.mismatch[2].text(), ".85");
        row("two effects: exact pair", self.pairs[0].text(), ".55");
        row("two effects: exact pair, or inseparable from it", self.pairs[1].text(), "");
        row("two effects: at least one", self.pairs[2].text(), "");
        row("two effects: noise floor reached", self.pairs[3].text(), ".90");
        row("held-out gap closed, median", figure(self.closed), ".98");
        row("95 % interval of it covers the truth", self.coverage.text(), ".95");
        let times = format!("{} ({})", figure(self.seconds[0]), figure(self.seconds[1]));
        row("seconds per diagnosis, median (90 % quantile)", times, "1");
        row("single effects that leave no trace", self.invisible.text(), "");
        row("diagnoses that failed", self.failed.to_string(), "0");
        row("cases without an answer", self.unanswered.to_string(), "0");
        table
    }

    fn by_distance(&self) -> Table {
        let header = ["squares of the noise that it leaves", "white noise", "AR(.8) noise"];
        let mut table = Table::new("Right cause first, by how much there is to see", &header);
        by_squares(&mut table, &self.top_by_distance);
        table
    }

    fn told(&self) -> Table {
        let header = [
            "squares of the noise that the nearest known effect leaves",
            "told at 3 %",
            "told by itself",
        ];
        let mut table = Table::new("Withheld classes told, by how near the library comes", &header);
        by_squares(&mut table, &self.told_by_nearest);
        table
    }

    fn shares(&self) -> Table {
        let header = ["visible effects", "said, median", "real, median", "interval covers"];
        let mut table = Table::new("Share of the held-out gap that is closed", &header);
        for of in &self.closed_by_kind {
            table.push([of.kind.clone(), figure(of.stated), figure(of.real), of.coverage.text()]);
        }
        table
    }

    fn baselines(&self) -> Table {
        let header = ["method", "right cause first", "held-out gap closed, median"];
        let mut table = Table::new("Simpler methods on the visible single effects", &header);
        table.push(["diagnosis", &self.strict_top.text(), &figure(self.closed)]);
        let [refit, black_box, sparse] = self.baseline_closed.map(figure);
        table.push(["wide refit of parameters", &self.baseline_top[0].text(), &refit]);
        table.push(["black-box compensation (ARX, free run)", "names nothing", &black_box]);
        table.push(["sparse regression on residual rates", &self.baseline_top[1].text(), &sparse]);
        table
    }

    fn reliability(&self) -> Table {
        let header = ["stated", "right: matched laws", "right: mismatched laws"];
        let mut table = Table::new("Reliability of the group posterior", &header);
        for i in 0..10 {
            let (low, high) = (f64::from(i) / 10.0, f64::from(i + 1) / 10.0);
            let text = |c: &Calibration| {
                let bin = c.bins.iter().find(|b| low <= b.stated && (b.stated < high || i == 9));
                bin.map_or_else(|| "-".to_owned(), |bin| bin.right.text())
            };
            table.push([
                format!("{low:.1}..{high:.1}"),
                text(&self.group[0]),
                text(&self.group[1]),
            ]);
        }
        table
    }

    /// What was put in, by mechanism, against what was said; single effects and no gap.
    fn confusion(&self) -> Table {
        let known = || self.verdicts.iter().filter(|v| v.kind == "single" || v.kind == "none");
        let mut truths: Vec<&str> = known().map(|v| v.truth_family.as_str()).collect();
        let mut said: Vec<&str> = known().map(|v| v.said_family.as_str()).collect();
        for list in [&mut truths, &mut said] {
            list.sort_unstable();
            list.dedup();
        }
        let mut header = vec!["truth \\ said"];
        header.extend(&said);
        let title = "Confusion of mechanisms, single effects and no gap";
        let mut table = Table::new(title, &header);
        for truth in truths {
            let count = |s: &&str| {
                let both = |v: &&super::Verdict| v.truth_family == truth && v.said_family == **s;
                known().filter(both).count()
            };
            let mut row = vec![truth.to_owned()];
            row.extend(said.iter().map(|s| match count(s) {
                0 => String::new(),
                n => n.to_string(),
            }));
            table.push(row);
        }
        table
    }

    /// What was right and wrong, case by case.
    fn mistakes(&self) -> Table {
        let header = ["case", "kind", "plant", "truth", "said", "p", "D"];
        let mut table = Table::new("Visible effects that were not found", &header);
        let counts =
            |v: &super::Verdict| v.kind == "single" || v.kind == "mismatch" || !v.is_plain();
        let wrong = |v: &&super::Verdict| v.is_visible && !v.is_right && counts(v);
        for v in self.verdicts.iter().filter(wrong).take(LISTED) {
            table.push([
                v.case.clone(),
                v.kind.clone(),
                v.plant.clone(),
                v.truth.join(" + "),
                if v.says_none { format!("none of these ({})", v.said) } else { v.said.clone() },
                format!("{:.2}", v.probability),
                figure(v.distance),
            ]);
        }
        table
    }

    /// Stated probabilities against how often they were right.
    #[must_use]
    pub fn diagram(&self) -> Picture {
        let line = |name: &str, c: &Calibration| {
            Line::new(name, c.bins.iter().map(|bin| (bin.stated, bin.right.share)))
        };
        Picture {
            title: "Reliability of mechanism and place".to_owned(),
            x_label: "stated probability".to_owned(),
            y_label: "share that is right".to_owned(),
            lines: vec![
                Line::new("perfect", [(0.0, 0.0), (1.0, 1.0)]),
                line("matched laws", &self.group[0]),
                line("mismatched laws", &self.group[1]),
            ],
            ..Picture::default()
        }
    }

    /// The page.
    ///
    /// # Errors
    ///
    /// Returns an error when the diagram cannot be drawn.
    pub fn page(&self) -> Result<Page, PictureError> {
        let mut page = Page::new("Blind test of the gap diagnosis", self.headline());
        for table in self.tables() {
            page.table(table);
        }
        page.picture(&self.diagram(), "On the diagonal probabilities mean what they say.")?;
        page.table(self.mistakes());
        Ok(page)
    }

    /// The tables as Markdown.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = format!("# Blind test of the gap diagnosis\n\n{}.\n", self.headline());
        text += "\nShares have 95 % intervals (Wilson). A case is visible when the best fit without \
                 any effect leaves at least 9 squares of the noise of the noise-free truth, with \
                 parameters about the real or the nominal ones, whatever leaves less; an answer is \
                 inseparable from the truth when it leaves less.\n";
        let mut tables = self.tables();
        tables.push(self.mistakes());
        for table in tables {
            let _ = write!(text, "\n## {}\n\n{}", table.title, table.to_markdown());
        }
        text
    }
}

impl std::fmt::Display for Rate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.text())
    }
}

/// Rows of two rates, each from some squares of the noise up to those of the next.
fn by_squares(table: &mut Table, rows: &[BySquares]) {
    let nexts = rows.iter().skip(1).map(|row| Some(row.least));
    for (BySquares { least, rates }, next) in rows.iter().zip(nexts.chain([None])) {
        let range =
            next.map_or_else(|| format!("{least} and more"), |next| format!("{least} to {next}"));
        table.push([range, rates[0].text(), rates[1].text()]);
    }
}
