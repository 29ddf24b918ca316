//! A possible answer: an explanation of the logs, and the choice among several.

use fd_effect::SiteRef;
use fd_sim::model::Model;

use super::{explain::explain, measurement::MeasurementCause};
use crate::{
    diagnose::result::Explanation,
    evidence::grades::VERY_STRONG,
    fit::{Minimum, Problem, Variable},
    shrink::Paths,
};

/// Whether the evidence of two causes is so much more than that of one that a second is worth its name.
pub(crate) fn is_a_pair(two: f64, one: f64) -> bool {
    one + VERY_STRONG < two
}

/// An explanation with what it rests on.
#[derive(Clone, Debug)]
pub(in crate::diagnose) struct Answer {
    pub explanation: Explanation,
    /// Errors in sigma.
    pub errors: Vec<Vec<Vec<f64>>>,
    /// The fit, if a simulated effect is part of it.
    pub fit: Option<Fit>,
    /// How many effects there are in it.
    pub effects: usize,
    /// Logarithm of the evidence over that of "no gap".
    pub log_evidence: f64,
}

/// A fitted problem.
#[derive(Clone, Debug)]
pub(in crate::diagnose) struct Fit {
    pub problem: Problem,
    pub minimum: Minimum,
}

impl Fit {
    /// What is made of its paths over time in another log: where it is nothing but paths, they are drawn anew, as no
    /// forecast of them is possible. Beside a law a path has to forecast, or the two would follow anything.
    pub(in crate::diagnose) fn paths(&self) -> Paths {
        let effects = self.problem.effects();
        if !effects.is_empty() && effects.iter().all(Variable::is_path) {
            Paths::Anew
        } else {
            Paths::AsFitted
        }
    }
}

/// An answer and what must speak for it.
#[derive(Clone, Debug)]
pub(super) struct Proposal {
    pub answer: Answer,
    /// Evidence over that of the best plainer answer from which it is preferred.
    pub price: f64,
}

/// The answer to prefer: that of the refitted model, or the last of the proposals, the plainest
/// first, that is worth its price over the best one before it.
pub(super) fn choose(refit: &Answer, proposals: impl IntoIterator<Item = Proposal>) -> Answer {
    proposals.into_iter().fold(refit.clone(), |best, Proposal { answer, price }| {
        if best.log_evidence + price < answer.log_evidence { answer } else { best }
    })
}

impl Answer {
    /// The answer of a fit with so many effects; `None` when it diverges.
    pub(in crate::diagnose) fn of(
        model: &Model,
        problem: &Problem,
        best: &Minimum,
        effects: usize,
        log_evidence: f64,
    ) -> Option<Self> {
        let mut problem = problem.clone();
        let explanation = explain(model, &mut problem, &best.z)?;
        let errors = problem.errors(&best.z)?;
        let fit = Some(Fit { problem, minimum: best.clone() });
        Some(Self { explanation, errors, fit, effects, log_evidence })
    }

    /// The same with a cause of the measurement besides, whose traces do not count as left.
    pub(in crate::diagnose) fn with(&self, measured: &MeasurementCause<'_>) -> Self {
        let mut answer = Self {
            effects: self.effects + 1,
            log_evidence: self.log_evidence + measured.gain,
            ..self.clone()
        };
        if let SiteRef::Output(output, _) = &measured.candidate.site
            && let Some(errors) = answer.errors.get_mut(*output)
        {
            errors.clone_from(&measured.left);
        }
        answer
    }
}
