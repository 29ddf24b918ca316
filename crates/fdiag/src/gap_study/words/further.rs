//! What goes beyond the log: another experiment, simulated logs of known cause.

use fd_gap::{
    calibrate::Confusion,
    diagnose::Diagnosis,
    experiment::{Advice, Rival},
};

use super::{answer, labels::capital};

/// What is to be told apart, the leader first.
#[must_use]
pub fn rivals(advice: &Advice, diagnosis: &Diagnosis) -> Vec<String> {
    let name = |rival: &Rival| match rival {
        Rival::NoGap => Some("no gap".to_owned()),
        Rival::Cause(id) => diagnosis.cause(*id).map(answer::cause),
        Rival::Pair(id) => diagnosis.pair(*id).map(answer::pair),
    };
    advice.between.iter().filter_map(name).collect()
}

/// What to do next, with the names that causes have everywhere in a report; empty when there is nothing
/// to be said.
#[must_use]
pub fn advice(advice: &Advice, diagnosis: &Diagnosis) -> String {
    let pairs = advice.names.iter().zip(rivals(advice, diagnosis));
    let statement = pairs.fold(advice.statement.clone(), |s, (from, to)| s.replace(from, &to));
    capital(&statement)
}

/// True causes of the rows of a confusion matrix.
#[must_use]
pub fn truths(confusion: &Confusion, diagnosis: &Diagnosis) -> Vec<String> {
    let name = |cause| match cause {
        None => Some("no gap".to_owned()),
        Some(id) => diagnosis.cause(id).map(answer::cause),
    };
    let truths = confusion.truths.iter();
    truths.map(|truth| name(truth.cause).unwrap_or_else(|| truth.name.clone())).collect()
}

/// Answers of the columns of a confusion matrix: the true causes, then the others.
#[must_use]
pub fn answers(confusion: &Confusion, diagnosis: &Diagnosis) -> Vec<String> {
    let mut answers = truths(confusion, diagnosis);
    answers.extend(confusion.columns.iter().skip(answers.len()).cloned());
    answers
}
