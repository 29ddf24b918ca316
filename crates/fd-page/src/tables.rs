//! What the terminal shows below the headline.

use fd_gap::{
    diagnose::{Cause, CauseId, HeldOut, PairId, Verdict},
    fit::Horizon,
    quality::Severity,
    road::CauseList,
};
use fd_model::figure;
use fd_report::Table;

use fdiag::gap_study::{
    Inputs, Report, Whole, Window,
    words::{self, percent, probability, share},
};

/// Least probability of a row.
const SHOWN: f64 = 0.01;
/// Most rows of causes and of groups.
const ROWS: usize = 6;

/// Short tables for a terminal.
#[must_use]
pub fn tables(report: &Report) -> Vec<Table> {
    let mut tables = Vec::new();
    if report.spoiled().is_none() {
        tables.extend(report.road.as_ref().map(road));
        tables.extend([groups(report), causes(report)].into_iter().flatten());
        if !report.diagnosis.held_out.is_empty() {
            tables.push(how_far(&report.diagnosis.held_out, &report.inputs));
        }
        tables.extend(report.whole.as_ref().map(all_rows));
        tables.extend(against(report));
        tables.extend(next(report));
    }
    tables.extend(findings(report));
    tables
}

/// A title of what is said of single causes, beside a list of several.
pub(crate) fn titled(title: &str, report: &Report) -> String {
    if report.list().is_some() {
        format!("{title}, if it were one alone")
    } else {
        title.to_owned()
    }
}

/// Mechanisms at places.
fn groups(report: &Report) -> Option<Table> {
    let header = ["mechanism", "side", "probability"];
    let mut table = Table::new(titled("Mechanism and place", report), &header);
    let diagnosis = &report.diagnosis;
    for group in diagnosis.groups.iter().filter(|g| SHOWN <= g.probability).take(ROWS) {
        let side = words::side(group.side).to_owned();
        table.push([words::group(group), side, probability(group.probability)]);
    }
    for (name, p) in [("no gap", diagnosis.no_gap), ("none of these", diagnosis.none_of_these)] {
        if SHOWN <= p {
            table.push([name.to_owned(), String::new(), probability(p)]);
        }
    }
    (!table.rows.is_empty()).then_some(table)
}

/// Single causes, or the causes of the pairs.
fn causes(report: &Report) -> Option<Table> {
    let header = ["cause", "law", "strength", "probability", ""];
    let mut table = Table::new(titled("Cause", report), &header);
    if report.diagnosis.verdict == Verdict::Pair {
        pairs(report, &mut table);
    }
    let all = report.diagnosis.causes.iter().enumerate();
    let all = all.map(|(i, cause)| (CauseId(i), cause));
    let is_shown =
        |(id, cause): &(CauseId, &Cause)| SHOWN <= cause.probability || report.tied().contains(id);
    for (id, cause) in all.filter(is_shown).take(ROWS) {
        let rival = report.diagnosis.rivals.iter().find(|rival| rival.cause == id);
        let remark = match rival {
            _ if report.tied().contains(&id) => "tied".to_owned(),
            Some(rival) => format!("apart by {} sigma²", figure(rival.distance)),
            None => String::new(),
        };
        let (name, strength) = (words::cause(cause), words::strength(cause));
        table.push([name, cause.law.to_owned(), strength, probability(cause.probability), remark]);
    }
    (!table.rows.is_empty()).then_some(table)
}

/// The causes of pairs, two rows each.
fn pairs(report: &Report, table: &mut Table) {
    for (i, pair) in report.diagnosis.pairs.iter().enumerate().take(ROWS) {
        let is_tied = report.tied_pairs().contains(&PairId(i));
        if pair.probability < SHOWN && !is_tied {
            continue;
        }
        for (i, cause) in pair.causes.iter().enumerate() {
            let (name, strength) = (words::cause(cause), words::strength(cause));
            let (name, p) = match i {
                0 => (name, probability(pair.probability)),
                _ => (format!("and {name}"), String::new()),
            };
            let tied = if is_tied { "tied pair" } else { "pair" };
            table.push([name, cause.law.to_owned(), strength, p, tied.to_owned()]);
        }
    }
}

/// What the stretches of long logs say of all rows.
pub(crate) fn all_rows(whole: &Whole) -> Table {
    let header = ["rows", "refitted", "explained"];
    let mut table =
        Table::new("All rows, forecast in windows (errors in units of the noise)", &header);
    let Whole { rows, fitted, window, windows, .. } = whole;
    let all = format!("{rows} in {windows} windows of {window}; fitted: {fitted}");
    table.push([all, figure(whole.refitted), figure(whole.explained)]);
    for Window { file, rows: [from, to], refitted, explained, .. } in &whole.unlike {
        let rows = format!("{from} to {to} of {file}: unlike the others");
        table.push([rows, figure(*refitted), figure(*explained)]);
    }
    table
}

/// Gaps on held-out data.
pub(crate) fn how_far(horizons: &[HeldOut], inputs: &Inputs) -> Table {
    let header = [
        "horizon",
        "output",
        "constant",
        "last value",
        "nominal",
        "refitted",
        "explained",
        "floor",
        "gap closed",
    ];
    let mut table = Table::new("How far, on held-out data (rms)", &header);
    for held_out in horizons {
        let name = match held_out.horizon {
            Horizon::FreeRun => "free run".to_owned(),
            Horizon::Windows { .. } => format!("{} s", figure(held_out.seconds)),
        };
        for (i, output) in inputs.outputs.iter().enumerate() {
            let closed = held_out.closed().filter(|_| i == 0);
            let closed = closed.map_or_else(String::new, |c| share(c.fraction, c.interval));
            let name = if i == 0 { name.clone() } else { String::new() };
            let output = format!("{} [{}]", output.name, output.unit);
            let HeldOut { constant, last_value, nominal, refit, after, floor, .. } = held_out;
            let sizes = [constant, last_value, nominal, refit, after, floor];
            let sizes = sizes.map(|of_outputs| figure(of_outputs[i]));
            table.push([name, output].into_iter().chain(sizes).chain([closed]));
        }
    }
    table
}

/// Several causes, one after another.
pub(crate) fn road(road: &CauseList) -> Table {
    let header = ["cause", "law", "probability", "tied with", "closes of what was left", "share"];
    let mut table = Table::new("Several causes", &header);
    for listed in &road.causes {
        let closed = listed.closed.map_or_else(String::new, |c| share(c.fraction, c.interval));
        table.push([
            words::with_strength(&listed.cause),
            listed.cause.law.to_owned(),
            probability(listed.probability),
            listed.tied.join(", "),
            closed,
            listed.share.map_or_else(String::new, percent),
        ]);
    }
    for (name, of_gap) in [("unexplained", road.unexplained), ("noise", road.noise)] {
        if of_gap.is_finite() {
            let row = [name, "", "", "", ""].map(str::to_owned);
            table.push(row.into_iter().chain([percent(of_gap)]));
        }
    }
    table
}

/// What speaks against the answer.
fn against(report: &Report) -> Option<Table> {
    let mut table = Table::new("Against it", &["objection"]);
    for objection in &report.diagnosis.objections {
        table.push([words::objection(objection)]);
    }
    (!table.rows.is_empty()).then_some(table)
}

fn next(report: &Report) -> Option<Table> {
    let mut table = Table::new("What next", &["experiment, sensor, sampling or line of the model"]);
    for step in &report.next {
        table.push([step.clone()]);
    }
    (!table.rows.is_empty()).then_some(table)
}

/// What is wrong with the logs.
pub(crate) fn findings(report: &Report) -> Option<Table> {
    let mut table = Table::new("About the logs", &["log", "channel", "finding"]);
    for finding in &report.findings {
        let text = words::defect(&finding.defect);
        let text = match finding.severity {
            Severity::Serious => format!("SERIOUS: {text}"),
            Severity::Warning | Severity::Note => text,
        };
        table.push([finding.file.clone(), finding.channel.clone(), text]);
    }
    (!table.rows.is_empty()).then_some(table)
}
