//! Findings about the logs, under the names of their files.

use fd_gap::{
    diagnose::Diagnosis,
    quality::{Defect, Finding, Severity},
};
use fd_sim::model::Model;

use super::{data::Data, report::FindingReport, words::four};

/// Steps of a file may differ from that of the model by this part before it is worth a note.
const SAME_PACE: f64 = 1e-3;

/// Findings of a diagnosis and of the time bases, the worst first.
pub(super) fn findings(diagnosis: &Diagnosis, data: &Data, nominal: &Model) -> Vec<FindingReport> {
    let files: Vec<String> = data.parts.iter().map(|p| file_name(&p.file)).collect();
    let mut all: Vec<(Severity, FindingReport)> = diagnosis
        .findings
        .iter()
        .map(|finding| (finding.severity(), report(finding, &files)))
        .collect();
    let note = |kind, file: &str, text| FindingReport {
        severity: "note",
        kind,
        file: file.to_owned(),
        channel: "time".to_owned(),
        text,
    };
    for (part, file) in data.parts.iter().zip(&files).filter(|(p, _)| p.samples[0] == 0) {
        let base = &part.time_base;
        if !base.gaps.is_empty() {
            let text = format!("{} holes are too long to be bridged", base.gaps.len());
            all.push((Severity::Note, note("missing", file, text)));
        }
        if !base.even {
            let text = format!(
                "rows are {} s apart (jitter {} s): resampled to {} s",
                four(base.median_step_s),
                four(base.jitter_s),
                four(base.step_s)
            );
            all.push((Severity::Note, note("uneven", file, text)));
        }
    }
    let model_ts = nominal.sample_time;
    let ts = data.ts().map_or(model_ts, fd_model::SampleTime::seconds);
    if SAME_PACE * model_ts < (ts - model_ts).abs() {
        let text = format!(
            "samples are {} s apart, the model says {} s: it is simulated at the pace of the log",
            four(ts),
            four(model_ts)
        );
        all.push((Severity::Note, note("pace", files.first().map_or("", String::as_str), text)));
    }
    if !data.is_continued() && depends_on_time(nominal, &diagnosis.best.model) {
        let text = "the effect depends on the time since the start of a run, and held-out logs \
                    have a start of their own: what it does there may not carry over"
            .to_owned();
        let file = files.first().map_or("", String::as_str);
        all.push((
            Severity::Warning,
            FindingReport { severity: "warning", ..note("clock", file, text) },
        ));
    }
    all.sort_by_key(|(severity, _)| std::cmp::Reverse(*severity));
    all.into_iter().map(|(_, finding)| finding).collect()
}

/// Whether what a patch has added mentions the time.
fn depends_on_time(nominal: &Model, patched: &Model) -> bool {
    let count = |model: &Model| {
        let definitions = model.definitions.iter().map(|d| &d.value);
        let laws = model.all_states().map(|state| state.law.expr());
        let outputs = model.outputs.iter().map(|output| &output.value);
        definitions.chain(laws).chain(outputs).filter(|expr| expr.mentions("t")).count()
    };
    count(nominal) < count(patched)
}

/// The last part of a path, which is what people call a file.
pub(super) fn file_name(path: &std::path::Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

fn report(finding: &Finding, files: &[String]) -> FindingReport {
    let prefix = format!("log {}, `{}`: ", finding.log, finding.channel);
    let text = finding.to_string();
    FindingReport {
        severity: match finding.severity() {
            Severity::Serious => "serious",
            Severity::Warning => "warning",
            Severity::Note => "note",
        },
        kind: match finding.defect {
            Defect::Quantised { .. } => "quantised",
            Defect::Clipped { .. } => "clipped",
            Defect::Constant => "constant",
            Defect::NotExcited => "not-excited",
            Defect::Missing { .. } => "missing",
            Defect::SlowSampling { .. } => "slow-sampling",
            Defect::Feedback { .. } => "feedback",
            Defect::WrongUnit { .. } => "wrong-unit",
            Defect::Swapped { .. } => "swapped",
            Defect::Undriven => "undriven",
            Defect::Short { .. } => "short",
            _ => "other",
        },
        file: files.get(finding.log - 1).cloned().unwrap_or_default(),
        channel: finding.channel.clone(),
        text: text.strip_prefix(&prefix).unwrap_or(&text).to_owned(),
    }
}
