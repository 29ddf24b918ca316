//! The report as a page: pictures first, then what they rest on.

use fd_report::{Bar, Bars, Page, PictureError, Shares, Table, figure};

use super::{
    GapStudy,
    headline::{capital, spoiled},
    pictures,
    report::{CalibrationReport, HorizonReport, Report},
    tables,
    words::{four, probability, share},
};

/// Least probability of a bar.
const SHOWN: f64 = 0.005;
/// Least probability of a place that is worth a sentence.
const PLACED: f64 = 0.05;
/// Most bars.
const BARS: usize = 8;

impl GapStudy {
    /// The report as a page.
    ///
    /// # Errors
    ///
    /// Returns an error when a picture cannot be drawn.
    pub fn page(&self) -> Result<Page, PictureError> {
        let report = &self.report;
        let title = format!("{}: simulation and reality", report.input.model);
        let mut page = Page::new(title, &report.headline);
        for finding in report.findings.iter().filter(|finding| finding.severity == "serious") {
            let (file, channel) = (&finding.file, &finding.channel);
            page.warning(format!("{file}, {channel}: {}", finding.text));
        }
        if let Some(trace) = &self.trace {
            page.gallery(&pictures::runs(trace))?;
        }
        if spoiled(report).is_none() {
            which(&mut page, report)?;
            how_far(&mut page, report);
        }
        place(&mut page, report)?;
        next(&mut page, report);
        if let Some(calibration) = &report.calibration {
            confusion(&mut page, calibration);
        }
        basis(&mut page, report);
        Ok(page)
    }
}

/// Groups and causes with their probabilities, and the law.
fn which(page: &mut Page, report: &Report) -> Result<(), PictureError> {
    page.heading("Which effect");
    if report.regime == "above-the-floor" {
        page.text(
            "Nothing that was tried reaches the noise, so probabilities are how often a cause \
             forecasts best on blocks of the logs.",
        );
    }
    let mut groups = Bars { title: "Mechanism and place".to_owned(), bars: Vec::new() };
    for group in report.groups.iter().filter(|g| SHOWN <= g.probability).take(BARS) {
        groups.bars.push(Bar::new(&group.name, group.probability, probability(group.probability)));
    }
    for (name, p) in [("no gap", report.no_gap), ("none of these", report.none_of_these)] {
        if SHOWN <= p {
            groups.bars.push(Bar::new(name, p, probability(p)));
        }
    }
    let strongest = groups.bars.iter_mut().max_by(|a, b| a.value.total_cmp(&b.value));
    if let Some(bar) = strongest {
        bar.is_strong = true;
    }
    if !groups.bars.is_empty() {
        page.bars(groups);
    }
    let mut causes = Bars { title: "Cause".to_owned(), bars: Vec::new() };
    let is_named = |place: usize| match report.verdict {
        "cause" => place == 0,
        "tied" => report.causes[place].is_tied,
        _ => false,
    };
    // What is not the answer needs no law and no strength.
    let is_answer = !matches!(report.verdict, "no-gap" | "none-of-these");
    for (place, cause) in report.causes.iter().enumerate().take(BARS) {
        let is_tied = cause.is_tied && is_answer;
        if SHOWN <= cause.probability || is_tied {
            let tied = if is_tied { " (tied)" } else { "" };
            let label = format!("{}{tied}", cause.name);
            let text = probability(cause.probability);
            let bar = Bar::new(label, cause.probability, text);
            causes.bars.push(Bar { is_strong: is_named(place), ..bar });
        }
    }
    for pair in report.pairs.iter().filter(|pair| SHOWN <= pair.probability).take(BARS) {
        let names: Vec<&str> = pair.causes.iter().map(|cause| cause.name.as_str()).collect();
        let tied = if pair.is_tied { " (tied)" } else { "" };
        let label = format!("{}{tied}", names.join(" and "));
        let bar = Bar::new(label, pair.probability, probability(pair.probability));
        causes.bars.push(Bar { is_strong: report.verdict == "pair" && pair.is_tied, ..bar });
    }
    if report.verdict == "pair" && !report.pairs.iter().any(|pair| pair.is_tied) {
        let first = causes.bars.iter_mut().find(|bar| bar.label.contains(" and "));
        if let Some(bar) = first {
            bar.is_strong = true;
        }
    }
    if !causes.bars.is_empty() {
        page.bars(causes);
    }
    if !is_answer {
        return Ok(());
    }
    if report.causes.iter().any(|cause| cause.is_tied) {
        page.text(
            "Tied causes predict the same to within the noise of this log: it cannot tell them \
             apart, whatever their probabilities are.",
        );
    }
    page.table(parameters(report));
    if let Some(law) = &report.law {
        page.gallery(&[pictures::law(law)])?;
    }
    Ok(())
}

/// Parameters of the causes that are named.
fn parameters(report: &Report) -> Table {
    let mut table = Table::new("Fitted", &["cause", "value", "parameter", "law"]);
    let singles = report.causes.iter().enumerate().filter(|(i, c)| *i == 0 || c.is_tied);
    let causes: Vec<_> = match report.pairs.first().filter(|_| report.verdict == "pair") {
        Some(pair) => pair.causes.iter().collect(),
        None => singles.map(|(_, cause)| cause).collect(),
    };
    for cause in causes {
        for (i, parameter) in cause.parameters.iter().enumerate() {
            let first = |text: &str| if i == 0 { text.to_owned() } else { String::new() };
            let value = parameter.words();
            table.push([first(&cause.name), value, parameter.name.clone(), first(cause.law)]);
        }
    }
    table
}

fn how_far(page: &mut Page, report: &Report) {
    page.heading("How far the gap shrinks");
    if report.how_far.is_empty() {
        page.text("Nothing was held out, so this is not known.");
        return;
    }
    let name = |horizon: &HorizonReport| match horizon.horizon {
        "free-run" => "free run".to_owned(),
        _ => format!("forecasts of {} s", figure(horizon.seconds)),
    };
    let bars = report.how_far.iter().enumerate().filter_map(|(i, horizon)| {
        let closed = horizon.closed()?;
        let interval = [closed.low, closed.high];
        let bar = Bar::new(name(horizon), closed.fraction, share(closed.fraction, interval));
        Some(Bar { interval: Some(interval), is_strong: i == 0, ..bar })
    });
    page.bars(Bars {
        title: "Share of the gap above the noise floor that is closed, with 95 % interval".into(),
        bars: bars.collect(),
    });
    page.text(
        "Compared with the model whose parameters were refitted within their tolerances; on data \
         that no fit has seen.",
    );
    page.table(tables::how_far(&report.how_far));
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
    let sides = report.sides.iter().filter(|side| PLACED <= side.probability);
    let sides = sides.map(|side| &side.statement);
    let statements = statements.chain(sides);
    let places = location.places.iter().filter(|p| PLACED <= p.probability).map(|p| &p.statement);
    for statement in statements.chain(places).filter(|s| !s.is_empty()) {
        page.text(format!("{}.", capital(statement)));
    }
    page.gallery(&pictures::places(report))
}

fn next(page: &mut Page, report: &Report) {
    let Some(advice) = &report.next else { return };
    page.heading("What would separate the rest");
    page.text(format!("{}.", advice.statement));
    let mut table = Table::new("Experiments that were simulated", &["experiment", "separates by"]);
    for tried in &advice.tried {
        let least = tried.distances.iter().copied().fold(f64::INFINITY, f64::min);
        table.push([tried.name.clone(), format!("{} sigma²", figure(least))]);
    }
    if !table.rows.is_empty() {
        page.table(table);
    }
}

fn confusion(page: &mut Page, calibration: &CalibrationReport) {
    page.heading("What such a log can tell");
    page.text(format!("{}.", capital(&calibration.statement)));
    let letter = |i: usize| char::from(b'A' + u8::try_from(i % 26).unwrap_or(0)).to_string();
    let rows = calibration.truths.iter().zip(&calibration.counts).zip(&calibration.replicas);
    let rows = rows.enumerate().map(|(i, ((truth, counts), n))| {
        let shares = counts.iter().map(|count| *count as f64 / (*n).max(1) as f64).collect();
        (format!("{} {truth}", letter(i)), shares)
    });
    let truths = calibration.truths.len();
    let columns = calibration.answers.iter().enumerate();
    page.shares(Shares {
        title: "Answers in percent, to simulated logs of known cause".to_owned(),
        corner: "true cause".to_owned(),
        columns: columns.map(|(i, a)| if i < truths { letter(i) } else { a.clone() }).collect(),
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
    for log in &report.input.logs {
        let missing = figure(100.0 * log.missing_share);
        let [from, to] = [log.from_s, log.to_s].map(figure);
        logs.push([log.file.clone(), log.role.into(), log.samples.to_string(), from, to, missing]);
    }
    page.table(logs);
    page.text(&report.input.policy);
    let header = ["parameter", "nominal", "refitted", "unit", "deviation [sd]"];
    let mut parameters = Table::new("Parameters of the model, with the best explanation", &header);
    for p in &report.parameters {
        let [nominal, refitted] = [p.nominal, p.refitted].map(four);
        let deviation = format!("{:+.1}", p.deviation_sd);
        parameters.push([p.name.clone(), nominal, refitted, p.unit.clone(), deviation]);
    }
    if !parameters.rows.is_empty() {
        page.table(parameters);
    }
    let mut files = Table::new("Files", &["file", "content"]);
    for file in report.files.iter().filter(|file| file.file != "report.html") {
        files.push([file.file.clone(), file.content.clone()]);
    }
    files.push(["report.json", "all of this as data; docs/gap-report.md describes it"]);
    page.table(files);
    let not_tested: Vec<String> = report
        .not_tested
        .iter()
        .map(|n| format!("{} ({}) at {}: {}", n.label, n.law, n.site.name, n.reason))
        .collect();
    if !not_tested.is_empty() {
        let summary = format!("{} candidates could not be tested here", not_tested.len());
        page.details(summary, not_tested.join("\n"));
    }
    if let Ok(settings) = serde_json::to_string_pretty(&report.settings) {
        page.details("Settings", settings);
    }
}
