//! The report as a page: pictures first, then what they rest on.

use fd_gap::{
    calibrate::Confusion,
    diagnose::{Cause, CauseId, HeldOut, PairId, Regime, SideShare, Verdict},
    fit::Horizon,
    locate::SideEvidence,
    quality::Severity,
};
use fd_model::{duration, figure};
use fd_report::{Bar, Bars, Page, PictureError, Shares, Table};

use fdiag::gap_study::{
    GapStudy, Report, Role,
    words::{self, capital, four, percent, probability, share},
};

use crate::{pictures, tables};

/// Least probability of a bar.
const SHOWN: f64 = 0.005;
/// Least probability of a place that is worth a sentence.
const PLACED: f64 = 0.05;
/// Most bars.
const BARS: usize = 8;

/// The report of a study as a page.
///
/// # Errors
///
/// Returns an error when a picture cannot be drawn.
pub fn page(study: &GapStudy) -> Result<Page, PictureError> {
    let report = &study.report;
    let title = format!("{}: simulation and reality", report.inputs.model);
    let mut page = Page::new(title, &report.headline);
    reading(&mut page, report);
    for finding in report.findings.iter().filter(|f| f.severity == Severity::Serious) {
        let (file, channel) = (&finding.file, &finding.channel);
        page.warning(format!("{file}, {channel}: {}", words::defect(&finding.defect)));
    }
    for objection in &report.diagnosis.objections {
        page.text(format!("{}.", capital(&words::objection(objection))));
    }
    if !report.stopped.is_empty() {
        let by = report.time_limit;
        let by = by
            .map_or_else(String::new, |limit| format!(" by its time limit of {}", duration(limit)));
        page.warning(format!(
            "It was stopped{by}, and has not come to: {}.",
            report.stopped.join(", ")
        ));
    }
    if let Some(trace) = &study.trace {
        page.gallery(&pictures::runs(trace))?;
    }
    if report.spoiled().is_none() {
        several(&mut page, report);
        which(&mut page, report)?;
        how_far(&mut page, report);
    }
    place(&mut page, report)?;
    if let Some(trace) = &study.trace {
        let summary = "Inputs and residuals over time, with the autocorrelation of residuals";
        page.folded(summary, &pictures::behind(trace))?;
    }
    next(&mut page, report);
    if let Some(calibration) = &report.calibration {
        confusion(&mut page, calibration, report);
    }
    basis(&mut page, report);
    Ok(page)
}

/// The road of causes, with what each takes away.
fn several(page: &mut Page, report: &Report) {
    let Some(road) = &report.road else { return };
    page.heading("Several causes");
    let mut bars = Bars { title: "Share of the held-out gap".to_owned(), bars: Vec::new() };
    for listed in &road.causes {
        let Some(share) = listed.share else { continue };
        let bar = Bar::new(words::with_strength(&listed.cause), share, percent(share));
        bars.bars.push(Bar { is_strong: true, ..bar });
    }
    for (name, share) in [("unexplained", road.unexplained), ("noise", road.noise)] {
        if share.is_finite() {
            bars.bars.push(Bar::new(name, share, percent(share)));
        }
    }
    if !bars.bars.is_empty() {
        page.bars(bars);
    }
    let why = match report.diagnosis.regime {
        Regime::AtTheFloor => {
            "Each was accepted because the likelihood asks for it beside all others, and forecasts of data that no fit \
             has seen do not contradict it; a share near zero may be a real but small effect."
        }
        Regime::AboveTheFloor => {
            "Each was accepted because it improves forecasts of data that no fit has seen, with all others present and \
             everything refitted together."
        }
    };
    page.text(format!("{why} patched.toml contains all of them."));
    page.table(tables::road(road));
}

/// What is read wrongly, and how to mend it.
fn reading(page: &mut Page, report: &Report) {
    let Some(reading) = &report.reading else { return };
    let p = words::p(reading.probability);
    page.warning(format!(
        "The log reads as if {} ({p}). Everything below refers to the corrected log. {}",
        reading.statement, reading.advice
    ));
    let lines = reading.lines.lines().filter(|line| !line.is_empty());
    lines.for_each(|line| page.text(line));
    let header = ["output", "error as read", "error corrected", "unit"];
    let mut table =
        Table::new("Best explanation as read, and plain fit with the mistake corrected", &header);
    let errors = reading.before.iter().zip(&reading.after);
    for (output, (before, after)) in report.inputs.outputs.iter().zip(errors) {
        let (name, unit) = (output.name.clone(), output.unit.clone());
        table.push([name, four(*before), four(*after), unit]);
    }
    page.table(table);
    if !reading.also.is_empty() {
        page.text(
            "Other mistakes would look the same in this log; report.json lists them under \
             `reading.also`.",
        );
    }
}

/// Groups and causes with their probabilities, and the law.
fn which(page: &mut Page, report: &Report) -> Result<(), PictureError> {
    page.heading("Which effect");
    if report.diagnosis.regime == Regime::AboveTheFloor {
        page.text(
            "None of the causes tried reaches the noise, so probabilities say how often a cause \
             forecasts best on resampled blocks of the logs, and how much it surely explains there.",
        );
    }
    for bars in [groups(report), causes(report)] {
        if !bars.bars.is_empty() {
            page.bars(bars);
        }
    }
    if !is_answer(report) {
        return Ok(());
    }
    if !report.tied().is_empty() {
        page.text(
            "Tied causes predict the same to within the noise of this log: it cannot tell them \
             apart, whatever their probabilities.",
        );
    }
    page.table(parameters(report));
    if let (Some(law), Some(cause)) = (&report.law, report.first_cause()) {
        page.gallery(&[pictures::law(law, cause)])?;
    }
    Ok(())
}

/// Whether causes are the answer: what is not needs no law and no strength.
fn is_answer(report: &Report) -> bool {
    !matches!(report.diagnosis.verdict, Verdict::NoGap | Verdict::NoneOfThese)
}

/// Probabilities of mechanisms at places.
fn groups(report: &Report) -> Bars {
    let diagnosis = &report.diagnosis;
    let mut groups =
        Bars { title: tables::titled("Mechanism and place", report), bars: Vec::new() };
    for group in diagnosis.groups.iter().filter(|g| SHOWN <= g.probability).take(BARS) {
        let p = group.probability;
        groups.bars.push(Bar::new(words::group(group), p, probability(p)));
    }
    for (name, p) in [("no gap", diagnosis.no_gap), ("none of these", diagnosis.none_of_these)] {
        if SHOWN <= p {
            groups.bars.push(Bar::new(name, p, probability(p)));
        }
    }
    let strongest = groups.bars.iter_mut().max_by(|a, b| a.value.total_cmp(&b.value));
    if let Some(bar) = strongest {
        bar.is_strong = true;
    }
    groups
}

/// Probabilities of causes and pairs; those that the verdict names are strong.
fn causes(report: &Report) -> Bars {
    let diagnosis = &report.diagnosis;
    let mut causes = Bars { title: tables::titled("Cause", report), bars: Vec::new() };
    for (i, cause) in diagnosis.causes.iter().enumerate().take(BARS) {
        let is_tied = report.tied().contains(&CauseId(i));
        if SHOWN <= cause.probability || is_tied && is_answer(report) {
            let tied = if is_tied && is_answer(report) { " (tied)" } else { "" };
            let is_strong = match diagnosis.verdict {
                Verdict::Cause => i == 0,
                Verdict::Tied => is_tied,
                _ => false,
            };
            let label = format!("{}{tied}", words::cause(cause));
            let bar = Bar::new(label, cause.probability, probability(cause.probability));
            causes.bars.push(Bar { is_strong, ..bar });
        }
    }
    let shown = diagnosis.pairs.iter().enumerate().filter(|(_, p)| SHOWN <= p.probability);
    for (place, (i, pair)) in shown.take(BARS).enumerate() {
        let is_tied = report.tied_pairs().contains(&PairId(i));
        let is_named = if report.tied_pairs().is_empty() { place == 0 } else { is_tied };
        let tied = if is_tied { " (tied)" } else { "" };
        let label = format!("{}{tied}", pair.causes.each_ref().map(words::cause).join(" and "));
        let bar = Bar::new(label, pair.probability, probability(pair.probability));
        let is_strong = diagnosis.verdict == Verdict::Pair && is_named;
        causes.bars.push(Bar { is_strong, ..bar });
    }
    causes
}

/// Parameters of the causes that are named.
fn parameters(report: &Report) -> Table {
    let mut table = Table::new("Fitted", &["cause", "value", "parameter", "law"]);
    let diagnosis = &report.diagnosis;
    let causes: Vec<&Cause> = match diagnosis.pairs.first() {
        Some(pair) if diagnosis.verdict == Verdict::Pair => pair.causes.iter().collect(),
        _ => {
            let singles = diagnosis.causes.iter().enumerate();
            let is_named = |i: usize| i == 0 || report.tied().contains(&CauseId(i));
            singles.filter(|(i, _)| is_named(*i)).map(|(_, cause)| cause).collect()
        }
    };
    for cause in causes {
        for (i, parameter) in cause.parameters.iter().enumerate() {
            let (name, law) = match i {
                0 => (words::cause(cause), cause.law),
                _ => (String::new(), ""),
            };
            let value = words::estimate_of(cause, parameter);
            table.push([name, value, parameter.name.clone(), law.to_owned()]);
        }
    }
    table
}

fn how_far(page: &mut Page, report: &Report) {
    page.heading("How far the gap shrinks");
    let horizons = &report.diagnosis.held_out;
    if horizons.is_empty() {
        page.text("Nothing was held out, so this is not known.");
        return;
    }
    let name = |held_out: &HeldOut| match held_out.horizon {
        Horizon::FreeRun => "free run".to_owned(),
        Horizon::Windows { .. } => format!("forecasts of {} s", figure(held_out.seconds)),
    };
    let bars = horizons.iter().enumerate().filter_map(|(i, held_out)| {
        let closed = held_out.closed()?;
        let text = share(closed.fraction, closed.interval);
        let bar = Bar::new(name(held_out), closed.fraction, text);
        Some(Bar { interval: Some(closed.interval), is_strong: i == 0, ..bar })
    });
    page.bars(Bars {
        title: "Share of the gap above the noise floor that is closed, with 95 % interval".into(),
        bars: bars.collect(),
    });
    page.text(
        "Compared with the model whose parameters were refitted within their tolerances; on data \
         that no fit has seen.",
    );
    page.table(tables::how_far(horizons, &report.inputs));
    if let Some(whole) = &report.whole {
        page.table(tables::all_rows(whole));
    }
    if let Some(ceiling) = report.ceiling.as_ref().filter(|c| !c.statement.is_empty()) {
        page.text(format!("{}.", capital(&ceiling.statement)));
    }
}

fn place(page: &mut Page, report: &Report) -> Result<(), PictureError> {
    let location = &report.location;
    if location.channels.is_empty() {
        return Ok(());
    }
    page.heading("Where the gap lies");
    let statements = location.channels.iter().map(|c| &c.statement);
    let sides = report.diagnosis.sides.iter().filter(|side| PLACED <= side.probability);
    let evidence = |of: &SideShare| location.sides.iter().find(|known| known.side == of.side);
    let sides = sides.filter_map(evidence).map(|known: &SideEvidence| &known.statement);
    let statements = statements.chain(sides);
    let places = location.places.iter().filter(|p| PLACED <= p.probability).map(|p| &p.statement);
    for statement in statements.chain(places).filter(|s| !s.is_empty()) {
        page.text(format!("{}.", capital(statement)));
    }
    if !report.diagnosis.held_out.is_empty() {
        page.text("These are the sizes in the fitted data; those above are of held-out data.");
    }
    page.gallery(&pictures::places(report))
}

fn next(page: &mut Page, report: &Report) {
    if report.next.is_empty() {
        return;
    }
    page.heading("What next");
    for step in &report.next {
        page.text(step.clone());
    }
    let Some(advice) = &report.advice else { return };
    let mut table = Table::new("Experiments that were simulated", &["experiment", "separates by"]);
    for tried in &advice.tried {
        let distance = format!("{} sigma²", figure(tried.least()));
        table.push([tried.experiment.name.clone(), distance]);
    }
    if !table.rows.is_empty() {
        page.table(table);
    }
}

fn confusion(page: &mut Page, calibration: &Confusion, report: &Report) {
    page.heading("What such a log can tell");
    page.text(format!("{}.", capital(&calibration.statement)));
    let letter = |i: usize| char::from(b'A' + u8::try_from(i % 26).unwrap_or(0)).to_string();
    let truths = words::truths(calibration, &report.diagnosis);
    let rows = truths.iter().zip(&calibration.counts).zip(&calibration.replicas);
    let rows = rows.enumerate().map(|(i, ((truth, counts), n))| {
        let shares = counts.iter().map(|count| *count as f64 / (*n).max(1) as f64).collect();
        (format!("{} {truth}", letter(i)), shares)
    });
    let others = calibration.columns.iter().skip(truths.len()).cloned();
    page.shares(Shares {
        title: "Answers in percent, to simulated logs of known cause".to_owned(),
        corner: "true cause".to_owned(),
        columns: (0..truths.len()).map(letter).chain(others).collect(),
        rows: rows.collect(),
    });
}

/// Logs, parameters, settings.
fn basis(page: &mut Page, report: &Report) {
    page.heading("What it rests on");
    if let Some(table) = tables::findings(report) {
        page.table(table);
    }
    let header = ["log", "used for", "samples", "from [s]", "to [s]", "missing [%]"];
    let mut logs = Table::new("Logs", &header);
    for log in &report.inputs.logs {
        let missing = figure(100.0 * log.missing_share);
        let ts = report.inputs.sample_time_s;
        let [from, to] = log.samples.map(|k| figure(k as f64 * ts));
        let role = match log.role {
            Role::Fit => "fit",
            Role::HeldOut => "held-out",
        };
        logs.push([log.file.clone(), role.into(), log.len().to_string(), from, to, missing]);
    }
    page.table(logs);
    page.text(words::time_policy(report.inputs.pace));
    let header = ["parameter", "nominal", "refitted", "unit", "moved [tolerances]", "these logs"];
    let mut parameters = Table::new("Parameters of the model, with the best explanation", &header);
    for p in &report.diagnosis.parameters {
        let refitted = words::with_error(p.value, p.standard_error);
        let (moved, says) = (format!("{:+.1}", p.tolerances), words::standing(p.standing));
        parameters
            .push([&p.name, &four(p.nominal), &refitted, &p.unit, &moved, says].map(String::from));
    }
    if !parameters.rows.is_empty() {
        page.table(parameters);
    }
    let mut files = Table::new("Files", &["file", "content"]);
    for model in &report.models {
        files.push([model.file.clone(), model.content.clone()]);
    }
    files.push(["report.json", "all of this as data; docs/gap-report.md describes it"]);
    page.table(files);
    let not_tested = report.diagnosis.not_tested.iter().map(|n| {
        let site = n.site.name().unwrap_or_default();
        format!("{} ({}) at {site}: {}", n.label, n.law, n.reason)
    });
    let not_tested: Vec<String> = not_tested.collect();
    if !not_tested.is_empty() {
        let summary = format!("{} candidates have no fit here, and why", not_tested.len());
        page.details(summary, not_tested.join("\n"));
    }
    if let Some(sparing) = report.sparing.as_ref().filter(|sparing| !sparing.left_out.is_empty()) {
        let left_out = &sparing.left_out;
        let summary = format!(
            "{} causes were tried on a linear model of the simulator alone",
            left_out.len()
        );
        page.details(summary, left_out.join("\n"));
    }
    if let Ok(settings) = serde_json::to_string_pretty(&report.settings) {
        page.details("Settings", settings);
    }
}
