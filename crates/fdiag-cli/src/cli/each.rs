//! `fdiag gap --each`: every log by itself, and what the answers agree on.

use std::{collections::BTreeSet, fs, path::Path};

use fd_report::{Page, Table};
use fdiag::gap_study::{Compared, ComparedCause, GapError, GapStudy, Request, words};

use super::{failure::Failure, output::Output};

/// The study of a log by its name.
pub(super) type Studied = (String, Result<GapStudy, GapError>);

/// A log by itself: the name of its directory, which is that of the file, with a number where two are alike, and its request.
fn requests(request: &Request) -> Vec<(String, Request)> {
    let mut taken = BTreeSet::new();
    let mut name = |path: &Path| {
        let stem = path.file_stem().map_or("log".into(), |stem| stem.to_string_lossy());
        let numbered = (2..).map(|n: usize| format!("{stem}-{n}"));
        let mut names = std::iter::once(stem.to_string()).chain(numbered);
        names.find(|name| taken.insert(name.clone())).unwrap_or_default()
    };
    let logs = request.logs.iter();
    logs.map(|log| (name(log), Request { logs: vec![log.clone()], ..request.clone() })).collect()
}

/// The study of each log, of which the report is written into a directory of its own as soon as it is there.
pub(super) fn studies(
    request: &Request,
    output: &Output<'_>,
    out: &Path,
    study: impl Fn(&Request) -> Result<GapStudy, GapError>,
) -> Result<Vec<Studied>, Failure> {
    let mut studies = Vec::with_capacity(request.logs.len());
    for (name, request) in requests(request) {
        let study = study(&request);
        if let Ok(study) = &study {
            write(output, out, &name, study)?;
        }
        studies.push((name, study));
    }
    Ok(studies)
}

/// Writes the report of one log into its directory.
fn write(output: &Output<'_>, out: &Path, name: &str, study: &GapStudy) -> Result<(), Failure> {
    let directory = out.join(name);
    fs::create_dir_all(&directory).map_err(|error| Failure::output(&directory, error))?;
    let page = fd_page::page(study).map_err(Failure::analysis)?;
    output.write(&format!("{name}/report.html"), &page.to_html())?;
    let json = format!("{name}/report.json");
    output.write(&json, &output.as_json(&json, &study.report)?)?;
    for model in &study.report.models {
        output.write(&format!("{name}/{}", model.file), &model.text)?;
    }
    Ok(())
}

/// What every log says of every cause, and what every log answers: all of it, or as far as the first semicolon.
fn tables(compared: &Compared, whole: bool) -> Vec<Table> {
    let names = compared.logs.iter().map(|answer| answer.log.as_str());
    let header: Vec<&str> =
        ["cause", "named by"].into_iter().chain(names).chain(["mean", "differ"]).collect();
    let mut causes = Table::new("Causes, log by log: probability and strength", &header);
    for cause in &compared.causes {
        causes.push(row(cause, compared.logs.len()));
    }
    let mut answers = Table::new("Answers", &["log", "answer"]);
    for answer in &compared.logs {
        let first = answer.headline.split(';').next().filter(|_| !whole);
        answers.push([answer.log.as_str(), first.unwrap_or(&answer.headline)]);
    }
    let causes = (!compared.causes.is_empty()).then_some(causes);
    causes.into_iter().chain([answers]).collect()
}

fn row(cause: &ComparedCause, logs: usize) -> Vec<String> {
    let name = words::effect_at(cause.label, &cause.site);
    let in_log = cause.logs.iter().map(|found| match found {
        Some(found) => format!("{} {}", words::probability(found.probability), found.strength),
        None => "no fit".to_owned(),
    });
    let means = cause.strengths.iter().map(|s| words::with_unit(s.mean, s.standard_error, &s.unit));
    let means: Vec<String> = means.collect();
    let differ = cause.strengths.iter().map(|strength| format!("{:.1} errors", strength.differ));
    let differ: Vec<String> = differ.collect();
    let named = format!("{} of {logs}", cause.named);
    [name, named].into_iter().chain(in_log).chain([means.join("; "), differ.join("; ")]).collect()
}

/// Writes the page that compares, and tells it.
pub(super) fn tell(
    output: &Output<'_>,
    compared: &Compared,
    inputs: &[&Path],
) -> Result<(), Failure> {
    let mut page = Page::new("Every log by itself", &compared.headline);
    page.text(
        "A cause that every log names with the same strength is one of the plant; one that a single log names is one of \
         that run, or chance. All logs together are diagnosed without --each.",
    );
    for table in tables(compared, true) {
        page.table(table);
    }
    output.finish(&compared.headline, &tables(compared, false), page, compared, inputs)
}
