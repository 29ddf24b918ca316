//! The answer of the diagnosis to a replica, and the probability that it gives the truth.

use crate::{
    diagnose::{Cause, CauseId, Diagnosis, Verdict},
    evidence::probabilities,
};

/// Least probability that counts in a logarithm.
const SMALLEST: f64 = 1e-6;
/// Standard deviation of the logarithm of the temperature, before any replica.
const TEMPERATURE_SPREAD: f64 = 0.7;
/// Temperatures that are tried: `0.2 · 1.1ⁱ`.
const TEMPERATURES: i32 = 50;

/// A diagnosed replica.
#[derive(Clone, Debug)]
pub(super) struct Outcome {
    /// Row of the truth.
    pub row: usize,
    /// Column of the answer.
    pub column: usize,
    /// Answers: "no gap" first, then causes, the tied ones as one. Which of them is the truth, and
    /// the evidence in each.
    pub answers: Answers,
}

/// Answers of a diagnosis with their evidence.
#[derive(Clone, Debug)]
pub(super) struct Answers {
    no_gap: f64,
    evidence: Vec<f64>,
    /// The tied causes, which count as one answer.
    tied: Vec<CauseId>,
    truth: Truth,
}

/// Where the truth is among the answers.
#[derive(Clone, Copy, Debug)]
enum Truth {
    NoGap,
    /// A cause.
    Cause(CauseId),
    /// A cause that was not tried.
    Absent,
}

/// Probabilities of the answers of a diagnosis.
#[derive(Clone, Debug)]
pub(super) struct Probabilities {
    no_gap: f64,
    /// Of the tied causes together.
    tied: f64,
    /// Of each other cause.
    others: Vec<(CauseId, f64)>,
}

impl Answers {
    /// `truth` is the true cause; `None` is "no gap".
    pub(super) fn of(diagnosis: &Diagnosis, truth: Option<&Cause>, no_gap: f64) -> Self {
        let place = |truth: &Cause| {
            let place = diagnosis.causes.iter().position(|c| c.identity() == truth.identity());
            place.map(CauseId)
        };
        Self {
            no_gap,
            evidence: diagnosis.causes.iter().map(|cause| cause.log_evidence).collect(),
            tied: diagnosis.tied.clone(),
            truth: truth
                .map_or(Truth::NoGap, |truth| place(truth).map_or(Truth::Absent, Truth::Cause)),
        }
    }

    /// Probabilities at a temperature.
    pub(super) fn probabilities(&self, temperature: f64) -> Probabilities {
        let prior = (1.0 - self.no_gap) / self.evidence.len().max(1) as f64;
        let causes = self.evidence.iter().map(|evidence| (*evidence, prior));
        let answers: Vec<(f64, f64)> = std::iter::once((0.0, self.no_gap)).chain(causes).collect();
        let all = probabilities(&answers, temperature);
        let (no_gap, causes) = all.split_first().map_or((1.0, &all[..]), |(p, rest)| (*p, rest));
        let tied = self.tied.iter().filter_map(|id| causes.get(id.0)).sum::<f64>().max(0.0);
        let others = causes.iter().copied().enumerate().map(|(i, p)| (CauseId(i), p));
        let others = others.filter(|(id, _)| !self.tied.contains(id)).collect();
        Probabilities { no_gap, tied, others }
    }

    /// Probability of the truth, or of the causes that are tied with it.
    pub(super) fn of_truth(&self, temperature: f64) -> f64 {
        let Probabilities { no_gap, tied, others } = self.probabilities(temperature);
        match self.truth {
            Truth::Absent => 0.0,
            Truth::NoGap => no_gap,
            Truth::Cause(cause) if self.tied.contains(&cause) => tied,
            Truth::Cause(cause) => others
                .iter()
                .find(|(other, _)| *other == cause)
                .map_or(0.0, |(_, probability)| *probability),
        }
    }

    /// The highest probability of an answer.
    pub(super) fn top(&self, temperature: f64) -> f64 {
        let Probabilities { no_gap, tied, others } = self.probabilities(temperature);
        others.iter().map(|(_, p)| *p).fold(no_gap.max(tied), f64::max)
    }

    /// How many answers have at least this probability.
    pub(super) fn at_least(&self, threshold: f64, temperature: f64) -> usize {
        let Probabilities { no_gap, tied, others } = self.probabilities(temperature);
        let all = others.iter().map(|(_, p)| *p).chain([no_gap, tied]);
        all.filter(|p| threshold <= *p && 0.0 < *p).count()
    }

    /// The answers with at least this probability; `None` is "no gap".
    pub(super) fn set(&self, threshold: f64, temperature: f64) -> Vec<Option<CauseId>> {
        let Probabilities { no_gap, tied, others } = self.probabilities(temperature);
        let is_in = |p: f64| threshold <= p && 0.0 < p;
        let mut set = Vec::new();
        if is_in(no_gap) {
            set.push(None);
        }
        if is_in(tied) {
            set.extend(self.tied.iter().copied().map(Some));
        }
        set.extend(others.iter().filter(|(_, p)| is_in(*p)).map(|(cause, _)| Some(*cause)));
        set
    }
}

/// The column of an answer: that of a true cause that is answered or tied with the answer, that of
/// the own row first; then another cause, then no answer.
pub(super) fn column(diagnosis: &Diagnosis, truths: &[Option<&Cause>], row: usize) -> usize {
    let (other, none) = (truths.len(), truths.len() + 1);
    let answered = match diagnosis.verdict {
        Verdict::NoGap => return 0,
        Verdict::Cause => diagnosis.causes.get(..1),
        Verdict::Tied => Some(diagnosis.causes.as_slice()),
        Verdict::Pair => return other,
        Verdict::NoneOfThese | Verdict::Unclear => return none,
    };
    let tied = answered.unwrap_or_default().iter().enumerate();
    let tied: Vec<&Cause> = tied
        .filter(|(i, _)| *i == 0 || diagnosis.tied.contains(&CauseId(*i)))
        .map(|(_, c)| c)
        .collect();
    let is_answered = |truth: Option<&Cause>| {
        truth.is_some_and(|truth| tied.iter().any(|answer| answer.identity() == truth.identity()))
    };
    if is_answered(truths[row]) {
        return row;
    }
    truths.iter().position(|truth| is_answered(*truth)).unwrap_or(other)
}

/// The temperature with the least sum of `−ln p` of the truth, with a prior for its logarithm about
/// the present one: where all answers are right, colder would always be better.
pub(super) fn best_temperature(outcomes: &[Outcome], present: f64) -> f64 {
    let loss = |temperature: f64| -> f64 {
        let p = outcomes.iter().map(|o| o.answers.of_truth(temperature).max(SMALLEST));
        let prior = 0.5 * ((temperature / present).ln() / TEMPERATURE_SPREAD).powi(2);
        prior - p.map(f64::ln).sum::<f64>()
    };
    let temperatures = (0..TEMPERATURES).map(|i| 0.2 * 1.1_f64.powi(i));
    let best = temperatures.map(|t| (loss(t), t)).min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or(present, |(_, temperature)| temperature)
}
