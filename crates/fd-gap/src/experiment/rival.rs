//! Explanations to be told apart, with the models that they were fitted as.

use fd_effect::Candidate;
use fd_sim::model::Model;

use super::result::Rival;
use crate::{
    diagnose::{Case, Cause, Diagnosis, LEADING, Start, Verdict},
    fit::Variable,
    locate::places::name,
};

/// "No gap" is a rival when it is at most this many times less probable than the leader.
const PROBABLE: f64 = 20.0;

/// An explanation with what is needed to refit it.
#[derive(Clone, Debug)]
pub(super) struct Contender<'a> {
    /// The model as a candidate brings it: parameters not settled.
    pub model: Model,
    /// Parameters of its effects, and their fitted values.
    pub effects: Vec<Variable>,
    pub values: Vec<f64>,
    /// The model with all values settled.
    pub fitted: &'a Model,
}

/// What is to be told apart: the pairs or causes that are tied, or else the leader and its rivals,
/// "no gap" among them while it is not out of the question. The leader comes first.
pub(super) fn between(diagnosis: &Diagnosis) -> Vec<Rival> {
    let mut all: Vec<Rival> = match diagnosis.verdict {
        Verdict::NoGap => Vec::new(),
        Verdict::Pair => diagnosis.tied_pairs.iter().copied().map(Rival::Pair).collect(),
        _ => match diagnosis.tied.as_slice() {
            [leader] => {
                let rivals = diagnosis.rivals.iter().map(|rival| rival.cause);
                std::iter::once(*leader).chain(rivals).map(Rival::Cause).collect()
            }
            tied => tied.iter().copied().map(Rival::Cause).collect(),
        },
    };
    let probability = match all.first() {
        Some(Rival::Cause(id)) => diagnosis.cause(*id).map(|cause| cause.probability),
        Some(Rival::Pair(id)) => diagnosis.pair(*id).map(|pair| pair.probability),
        Some(Rival::NoGap) | None => None,
    };
    if probability.is_some_and(|p| p <= PROBABLE * diagnosis.no_gap) {
        all.insert(1, Rival::NoGap);
    }
    if all.len() < 2 { Vec::new() } else { all.into_iter().take(1 + LEADING).collect() }
}

/// The settled model of the leader, and where its runs start if that is known.
pub(super) fn leader(diagnosis: &Diagnosis, rival: Rival) -> Option<(&Model, Option<&[Start]>)> {
    let model = match rival {
        Rival::NoGap => &diagnosis.refit.model,
        Rival::Cause(id) => &diagnosis.cause(id)?.model,
        Rival::Pair(id) => &diagnosis.pair(id)?.causes[0].model,
    };
    let known = [&diagnosis.best, &diagnosis.refit].into_iter().find(|e| e.model == *model);
    Some((model, known.map(|explanation| explanation.starts.as_slice())))
}

/// The name of an explanation.
pub(super) fn words(diagnosis: &Diagnosis, rival: Rival) -> String {
    let cause = |cause: &Cause| format!("{} at {}", cause.label, name(&cause.site));
    match rival {
        Rival::NoGap => "no gap".to_owned(),
        Rival::Cause(id) => diagnosis.cause(id).map(cause).unwrap_or_default(),
        Rival::Pair(id) => diagnosis.pair(id).map_or_else(String::new, |pair| {
            let [first, second] = pair.causes.each_ref().map(cause);
            format!("{first} with {second}")
        }),
    }
}

/// Rivals with the candidates that they were fitted as; those that cannot be simulated again are
/// left out.
pub(super) fn contenders<'a>(
    case: &Case<'_>,
    diagnosis: &'a Diagnosis,
    rivals: &[Rival],
) -> Vec<Contender<'a>> {
    let offers: Vec<Candidate> = case.suspects.alone().into_iter().filter_map(Result::ok).collect();
    let found = |offers: &[Candidate], cause: &Cause| -> Option<Candidate> {
        let is_it = |c: &&Candidate| c.law == cause.law && c.identity() == cause.identity();
        offers.iter().find(is_it).cloned()
    };
    let variables = |candidate: &Candidate| {
        candidate.parameters.iter().map(Variable::effect).collect::<Vec<_>>()
    };
    let values = |cause: &Cause| cause.parameters.iter().map(|p| p.value).collect::<Vec<_>>();
    let contender = |rival: &Rival| {
        Some(match *rival {
            Rival::NoGap => Contender {
                model: case.nominal.model().clone(),
                effects: Vec::new(),
                values: Vec::new(),
                fitted: &diagnosis.refit.model,
            },
            Rival::Cause(id) => {
                let cause = diagnosis.cause(id)?;
                let candidate = found(&offers, cause)?;
                let effects = variables(&candidate);
                let (model, values) = (candidate.model, values(cause));
                Contender { model, effects, values, fitted: &cause.model }
            }
            Rival::Pair(id) => {
                let [first, second] = &diagnosis.pair(id)?.causes;
                let one = found(&offers, first)?;
                let beside: Vec<Candidate> =
                    case.suspects.beside(&one).into_iter().filter_map(Result::ok).collect();
                let two = found(&beside, second)?;
                let effects = [variables(&one), variables(&two)].concat();
                let values = [values(first), values(second)].concat();
                Contender { model: two.model, effects, values, fitted: &first.model }
            }
        })
    };
    rivals.iter().filter_map(contender).collect()
}
