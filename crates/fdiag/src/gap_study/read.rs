//! Reads logs, checks them against the model, and divides them into what is fitted and what is held out.

use std::path::Path;

use fd_gap::{
    fit::FitError,
    quality::{Defect, leave_out_wrong_samples},
    reading::Mistake,
};
use fd_log::LogMap;
use fd_model::{Disorder, HeldInputs, Record, TimeBaseReport};
use fd_sim::model::{Hold, Model};

use super::{
    data::Data,
    error::GapError,
    log_finding::LogFinding,
    log_part::{LogPart, Pace, Role},
    long::shortened,
    request::{HeldOutChoice, Request},
    subject::Subject,
};

/// Ratio of sample times from which a unit must be wrong.
const ABSURD_PACE: f64 = 50.0;
/// Fewest measured values per unknown of a fit.
const PER_UNKNOWN: usize = 2;
/// Fewest unknowns that are reckoned with.
const FEWEST_UNKNOWNS: usize = 4;

/// Reads all logs; a mistake of reading is mended before they are divided.
pub(super) fn read_logs(
    request: &Request,
    subject: &Subject,
    mistake: Option<&Mistake>,
) -> Result<Data, GapError> {
    let model = subject.model();
    let (mut map, pace) = map(request, subject);
    let mut data = Data {
        fit: Vec::new(),
        held_out: Vec::new(),
        parts: Vec::new(),
        pace,
        findings: Vec::new(),
        long: None,
    };
    let mut findings = Vec::new();
    let mut origin = None;
    let mut read = |path: &Path| -> Result<(Record, TimeBaseReport), GapError> {
        let log = request.read(path, &map)?;
        let (expected, found) = (model.sample_time, log.time_base.median_step_s);
        let ratio = (found / expected).max(expected / found);
        if pace != Pace::Stated && ABSURD_PACE < ratio {
            let (file, column) = (path.to_owned(), log.time_column);
            return Err(GapError::Pace { file, column, expected, found });
        }
        // All logs are brought onto the time base of the first, which begins at 0 s.
        map.resample.sample_time.get_or_insert(log.record.ts().seconds());
        check(path, &log.record)?;
        let mended = mistake.and_then(|mistake| mistake.mended(&log.record));
        let record = mended.unwrap_or(log.record);
        let begin = record.time(0);
        let mut record = record.starting_at(begin - *origin.get_or_insert(begin));
        let wrong = leave_out_wrong_samples(&mut record);
        findings.extend(wrong.into_iter().map(|(channel, d)| LogFinding::of(path, channel, d)));
        Ok((record, log.time_base))
    };
    let mut later = Vec::new();
    for path in &request.logs {
        let (record, time_base) = read(path)?;
        let n = record.len();
        let cut = match request.held_out {
            HeldOutChoice::Logs(_) => n,
            HeldOutChoice::Split(share) => cut(n, share, needed(model)),
        };
        let part = |role, [from, to]: [usize; 2]| {
            let record = record.slice(from, to);
            (LogPart::new(path, role, [from, to], &record, &time_base), record)
        };
        let (fitted, record) = part(Role::Fit, [0, cut]);
        data.parts.push(fitted);
        data.fit.push(record);
        if cut < n {
            let (held_out, record) = part(Role::HeldOut, [cut, n]);
            later.push(held_out);
            data.held_out.push(record);
        }
    }
    let mut same = Vec::new();
    if let HeldOutChoice::Logs(paths) = &request.held_out {
        for path in paths {
            let (record, time_base) = read(path)?;
            if let Some(fitted) = data.fit.iter().find(|fitted| is_part(&record, fitted)) {
                let channel = fitted.outputs().first().map(|c| c.name.clone());
                let channel = channel.unwrap_or_default();
                same.push(LogFinding::of(path, channel, Defect::NotHeldOut));
                continue;
            }
            let samples = [0, record.len()];
            later.push(LogPart::new(path, Role::HeldOut, samples, &record, &time_base));
            data.held_out.push(record);
        }
    }
    data.parts.extend(later);
    data.findings = findings.into_iter().chain(same).collect();
    check_outputs(&data)?;
    check_lengths(&data, model)?;
    shortened(data, subject.nominal())
}

/// Every part needs enough values for the unknowns of a fit, held-out ones for their windows.
fn check_lengths(data: &Data, model: &Model) -> Result<(), GapError> {
    let all = data.fit.iter().chain(&data.held_out).zip(&data.parts).enumerate();
    for (i, (record, part)) in all {
        let outputs = (0..record.outputs().len()).flat_map(|c| record.output(c));
        let (found, needed) = (outputs.filter(|v| v.is_finite()).count(), needed(model));
        if found < needed {
            let (log, unknowns) = (i + 1, unknowns(model));
            let source = Box::new(FitError::TooShort { log, found, unknowns, needed });
            return Err(GapError::Unfit { file: part.path.clone(), source });
        }
    }
    Ok(())
}

/// An output that is measured in no log cannot be diagnosed.
fn check_outputs(data: &Data) -> Result<(), GapError> {
    let Some(first) = data.fit.first() else { return Ok(()) };
    for (c, channel) in first.outputs().iter().enumerate() {
        let is_measured = |record: &Record| record.output(c).any(f64::is_finite);
        if !data.fit.iter().any(is_measured) {
            let (file, rows) = (data.parts[0].path.clone(), first.len());
            let channel = channel.name.clone();
            return Err(GapError::Empty { file, role: "output", channel, rows });
        }
    }
    Ok(())
}

/// Whether a record is a part of another, from some sample of that on.
fn is_part(record: &Record, of: &Record) -> bool {
    let is_same = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits());
    let agrees = |from: usize| {
        (0..record.len())
            .all(|k| is_same(record.y(k), of.y(from + k)) && is_same(record.u(k), of.u(from + k)))
    };
    !record.is_empty() && record.len() <= of.len() && (0..=of.len() - record.len()).any(agrees)
}

/// The column map, completed with what the model and the user say.
fn map(request: &Request, subject: &Subject) -> (LogMap, Pace) {
    let [inputs, outputs] = subject.channels();
    let mut map = request.map(&inputs, &outputs);
    let policy = &mut map.resample;
    policy.sample_time = request.resample.sample_time.or(policy.sample_time);
    policy.max_gap_s = request.resample.longest_gap.or(policy.max_gap_s);
    if request.resample.disorder != Disorder::default() {
        policy.disorder = request.resample.disorder;
    }
    // What a model holds until the next sample has to have the integral of what was held in between; what it draws a line
    // through is on that line in between as well.
    let held = match subject.model().hold {
        Hold::Zero => HeldInputs::Mean,
        Hold::Linear => HeldInputs::Linear,
    };
    policy.held_inputs.get_or_insert(held);
    let is_stated = policy.sample_time.or(map.time.sample_time).is_some();
    let pace = match (is_stated, subject.keeps_pace()) {
        (true, _) => Pace::Stated,
        (false, true) => Pace::Model,
        (false, false) => Pace::FirstLog,
    };
    if pace == Pace::Model {
        policy.sample_time = Some(subject.model().sample_time);
    }
    (map, pace)
}

/// Every input needs at least one value.
fn check(path: &Path, record: &Record) -> Result<(), GapError> {
    for (i, channel) in record.inputs().iter().enumerate() {
        if !record.input(i).any(f64::is_finite) {
            return Err(GapError::Empty {
                file: path.to_owned(),
                role: "input",
                channel: channel.name.clone(),
                rows: record.len(),
            });
        }
    }
    Ok(())
}

/// Uncertain parameters, and all states, which are unknown at the start of a window.
fn unknowns(model: &Model) -> usize {
    let uncertain = model.parameters.iter().filter(|parameter| parameter.tolerance > 0.0);
    uncertain.count() + model.all_states().count()
}

/// Fewest measured values of a log.
fn needed(model: &Model) -> usize {
    PER_UNKNOWN * unknowns(model).max(FEWEST_UNKNOWNS)
}

/// Where a log is divided; one that is too short for two parts stays whole.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within 0..=n")]
fn cut(n: usize, share: f64, smallest: usize) -> usize {
    let cut = (share * n as f64).round() as usize;
    if cut < smallest || n - cut.min(n) < smallest { n } else { cut }
}
