//! All that is wrong with the logs of a study.

use std::cmp::Reverse;

use fd_gap::{
    diagnose::Diagnosis,
    quality::{Finding, Severity},
};
use fd_model::SampleTime;
use fd_sim::model::Model;

use super::{
    data::Data,
    log_finding::{LogDefect, LogFinding, TimeBaseDefect},
};

/// Rows per sample from which some are skipped.
const SKIPPING: f64 = 1.5;
/// Steps of a file may differ from that of the model by this part before it is worth a note.
const SAME_PACE: f64 = 1e-3;

/// Findings of a diagnosis, of the time bases, and those of the simulator that are known, the worst first.
pub(super) fn findings(
    diagnosis: &Diagnosis,
    data: &Data,
    nominal: &Model,
    of_simulator: Vec<LogFinding>,
) -> Vec<LogFinding> {
    let of_channel = |finding: &Finding| LogFinding {
        severity: finding.severity(),
        file: data.parts.get(finding.log - 1).map_or_else(String::new, |part| part.file.clone()),
        channel: finding.channel.clone(),
        defect: LogDefect::Channel(finding.defect.clone()),
    };
    let of_time = |severity, file: &str, defect| LogFinding {
        severity,
        file: file.to_owned(),
        channel: "time".to_owned(),
        defect: LogDefect::TimeBase(defect),
    };
    let mut all: Vec<LogFinding> = diagnosis.findings.iter().map(of_channel).collect();
    for part in data.parts.iter().filter(|part| part.samples[0] == 0) {
        let base = &part.time_base;
        if !base.gaps.is_empty() {
            let holes = TimeBaseDefect::Holes { count: base.gaps.len() };
            all.push(of_time(Severity::Note, &part.file, holes));
        }
        // Less is jitter: the median of the rows is what a grid is made of.
        if SKIPPING * base.median_step_s < base.step_s && !nominal.inputs.is_empty() {
            let (median_step_s, step_s) = (base.median_step_s, base.step_s);
            let coarse = TimeBaseDefect::Coarse { median_step_s, step_s };
            all.push(of_time(Severity::Warning, &part.file, coarse));
        }
        if !base.even {
            let uneven = TimeBaseDefect::Uneven {
                median_step_s: base.median_step_s,
                jitter_s: base.jitter_s,
                step_s: base.step_s,
            };
            all.push(of_time(Severity::Note, &part.file, uneven));
        }
    }
    let first = data.parts.first().map_or("", |part| part.file.as_str());
    let model_s = nominal.sample_time;
    let log_s = data.ts().map_or(model_s, SampleTime::seconds);
    if SAME_PACE * model_s < (log_s - model_s).abs() {
        all.push(of_time(Severity::Note, first, TimeBaseDefect::Pace { log_s, model_s }));
    }
    if !data.is_on_one_clock() && depends_on_time(nominal, &diagnosis.best.model) {
        all.push(of_time(Severity::Warning, first, TimeBaseDefect::Clock));
    }
    all.extend(data.findings.iter().cloned());
    all.extend(of_simulator);
    all.sort_by_key(|finding| Reverse(finding.severity));
    all
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
