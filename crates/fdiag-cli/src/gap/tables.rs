//! What the terminal shows below the headline.

use fd_report::{Table, figure};

use super::{
    GapStudy,
    headline::spoiled,
    report::{CauseReport, ClosedReport, HorizonReport, Report},
    words::{probability, share},
};

/// Least probability of a row.
const SHOWN: f64 = 0.01;
/// Most rows of causes and of groups.
const ROWS: usize = 6;

impl GapStudy {
    /// Short tables for a terminal.
    #[must_use]
    pub fn tables(&self) -> Vec<Table> {
        let report = &self.report;
        let mut tables = Vec::new();
        if spoiled(report).is_none() {
            tables.extend([groups(report), causes(report)].into_iter().flatten());
            if !report.how_far.is_empty() {
                tables.push(how_far(&report.how_far));
            }
            tables.extend(next(report));
        }
        tables.extend(findings(report));
        tables
    }
}

/// Mechanisms at places.
pub(super) fn groups(report: &Report) -> Option<Table> {
    let mut table = Table::new("Mechanism and place", &["mechanism", "side", "probability"]);
    for group in report.groups.iter().filter(|g| SHOWN <= g.probability).take(ROWS) {
        table.push([group.name.clone(), group.side.to_owned(), probability(group.probability)]);
    }
    for (name, p) in [("no gap", report.no_gap), ("none of these", report.none_of_these)] {
        if SHOWN <= p {
            table.push([name.to_owned(), String::new(), probability(p)]);
        }
    }
    (!table.rows.is_empty()).then_some(table)
}

/// Single causes, or the causes of the pairs.
pub(super) fn causes(report: &Report) -> Option<Table> {
    let header = ["cause", "law", "strength", "probability", ""];
    let mut table = Table::new("Cause", &header);
    let is_shown = |cause: &&CauseReport| SHOWN <= cause.probability || cause.is_tied;
    let pairs = report.pairs.iter().filter(|_| report.verdict == "pair").take(ROWS);
    for pair in pairs.filter(|pair| SHOWN <= pair.probability || pair.is_tied) {
        for (i, cause) in pair.causes.iter().enumerate() {
            let (name, law, strength) = (cause.name.clone(), cause.law, cause.strength.clone());
            let (name, p) = match i {
                0 => (name, probability(pair.probability)),
                _ => (format!("and {name}"), String::new()),
            };
            let tied = if pair.is_tied { "tied pair" } else { "pair" };
            table.push([name, law.to_owned(), strength, p, tied.to_owned()]);
        }
    }
    for cause in report.causes.iter().filter(is_shown).take(ROWS) {
        let remark = match (cause.is_tied, cause.rival_distance) {
            (true, _) => "tied".to_owned(),
            (false, Some(distance)) => format!("apart by {} sigma²", figure(distance)),
            (false, None) => String::new(),
        };
        table.push([
            cause.name.clone(),
            cause.law.to_owned(),
            cause.strength.clone(),
            probability(cause.probability),
            remark,
        ]);
    }
    (!table.rows.is_empty()).then_some(table)
}

/// Gaps on held-out data.
pub(super) fn how_far(horizons: &[HorizonReport]) -> Table {
    let header = ["horizon", "output", "before", "refitted", "after", "floor", "gap closed"];
    let mut table = Table::new("How far, on held-out data (rms)", &header);
    for horizon in horizons {
        let name = match horizon.horizon {
            "free-run" => "free run".to_owned(),
            _ => format!("{} s", figure(horizon.seconds)),
        };
        for (i, gap) in horizon.outputs.iter().enumerate() {
            let closed = horizon.closed().filter(|_| i == 0).map_or_else(String::new, closed);
            let name = if i == 0 { name.clone() } else { String::new() };
            let output = format!("{} [{}]", gap.output, gap.unit);
            let sizes = [gap.before, gap.refit, gap.after, gap.floor].map(figure);
            let [before, refit, after, floor] = sizes;
            table.push([name, output, before, refit, after, floor, closed]);
        }
    }
    table
}

fn closed(closed: ClosedReport) -> String {
    share(closed.fraction, [closed.low, closed.high])
}

fn next(report: &Report) -> Option<Table> {
    let advice = report.next.as_ref().filter(|advice| !advice.statement.is_empty())?;
    let mut table = Table::new("What next", &["experiment, sensor or sampling"]);
    table.push([advice.statement.clone()]);
    Some(table)
}

/// What is wrong with the logs.
pub(super) fn findings(report: &Report) -> Option<Table> {
    let mut table = Table::new("About the logs", &["log", "channel", "finding"]);
    for finding in &report.findings {
        let text = match finding.severity {
            "serious" => format!("SERIOUS: {}", finding.text),
            _ => finding.text.clone(),
        };
        table.push([finding.file.clone(), finding.channel.clone(), text]);
    }
    (!table.rows.is_empty()).then_some(table)
}
