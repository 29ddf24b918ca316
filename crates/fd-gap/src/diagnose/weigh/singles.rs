//! Single causes, weighed with the noise as it is taken to be.

use crate::together::each;
use fd_effect::Candidate;

use super::{
    answer::{Answer, Proposal},
    explain::explain,
    lack_of_fit::{LackOfFit, lack_of_fit},
    measurement::{Measured, MeasurementCause, weigh_measurement},
    priors::Priors,
    rank::{Basis, MeasurementId, RankedCause, Reference, rank, weigh_law},
};
use crate::{
    diagnose::{
        candidates::{Candidates, follows_anything, is_free_curve},
        search::searched::{Searched, TrialId},
        settings::Settings,
    },
    evidence::{evidence, likelihood},
    fit::{FitError, Problem},
};

/// Single causes with their evidence.
#[derive(Debug)]
pub(in crate::diagnose) struct Singles<'a> {
    pub searched: Searched<'a>,
    /// The problem without any effect.
    pub base: Problem,
    /// The nominal model with its parameters refitted.
    pub refit: Answer,
    pub reference: Reference,
    /// Causes of the measurement of which there is something in the log.
    pub measured: Vec<MeasurementCause<'a>>,
    /// The causes, the most evidence first.
    pub causes: Vec<RankedCause>,
}

/// Weighs every trial and every cause of the measurement against "no gap".
pub(in crate::diagnose) fn weigh_singles<'a>(
    mut searched: Searched<'a>,
    candidates: &'a Candidates,
) -> Result<Singles<'a>, FitError> {
    let mut base = searched.null.problem.clone();
    let at = &searched.null.minimum;
    let errors = base.errors(&at.z).ok_or(FitError::Diverged)?;
    let explanation = explain(&searched.model, &mut base, &at.z).ok_or(FitError::Diverged)?;
    let (noise, is_coloured) = (&searched.noise, searched.is_coloured);
    let priors = noise.priors(is_coloured);
    let log_evidence = evidence(&base, at, &likelihood(&errors, &priors), &[]);
    let log_evidence = log_evidence.ok_or(FitError::Diverged)?;
    let candidates = candidates.measured.iter();
    let measured = Measured { problem: &base, outputs: &explanation.outputs, errors: &errors };
    let measured: Vec<MeasurementCause<'_>> =
        candidates.filter_map(|c| weigh_measurement(c, measured, noise, is_coloured)).collect();
    let reference = Reference { noise: priors, log_evidence };
    let laws = each(searched.trials_mut(), |(id, trial)| weigh_law(id, trial, &reference));
    let causes = rank(laws.into_iter(), &measured, &explanation);
    let refit = Answer { explanation, errors, fit: None, effects: 0, log_evidence: 0.0 };
    Ok(Singles { searched, base, refit, reference, measured, causes })
}

impl<'a> Singles<'a> {
    /// A cause of the measurement by its id.
    pub(in crate::diagnose) fn measured(&self, id: MeasurementId) -> &MeasurementCause<'a> {
        &self.measured[id.0]
    }

    /// Whether the first cause is a free curve, which is no law.
    pub(in crate::diagnose) fn is_first_a_curve(&self) -> bool {
        self.simulated(0).is_some_and(is_free_curve)
    }

    /// Whether the first cause follows one log as it pleases.
    pub(in crate::diagnose) fn does_first_follow_anything(&self) -> bool {
        self.simulated(0).is_some_and(follows_anything)
    }

    /// What is tried as the cause at a place of the ranking; `None` for one of the measurement, and beyond the last.
    pub(in crate::diagnose) fn simulated(&self, place: usize) -> Option<&'a Candidate> {
        match self.causes.get(place)?.basis {
            Basis::Simulation(id) => Some(self.searched.trial(id).candidate),
            Basis::Measurement(_) => None,
        }
    }

    /// The answer of the first cause; `None` when there is none, or its simulation diverges.
    pub(in crate::diagnose) fn first_answer(&self) -> Option<Answer> {
        let RankedCause { basis, cause } = self.causes.first()?;
        match basis {
            Basis::Measurement(id) => Some(self.refit.with(self.measured(*id))),
            Basis::Simulation(id) => self.answer_of(*id, cause.log_evidence),
        }
    }

    /// The answer of the first cause that is a law; `None` when there is none, or its simulation diverges.
    pub(in crate::diagnose) fn first_law(&self) -> Option<Answer> {
        let mut causes = self.causes.iter();
        causes.find_map(|ranked| match ranked.basis {
            Basis::Simulation(id) if !follows_anything(self.searched.trial(id).candidate) => {
                self.answer_of(id, ranked.cause.log_evidence)
            }
            _ => None,
        })
    }

    /// The answer of a trial, with the evidence of its cause.
    pub(in crate::diagnose) fn answer_of(&self, id: TrialId, log_evidence: f64) -> Option<Answer> {
        let trial = self.searched.trial(id);
        Answer::of(&trial.model, &trial.problem, trial.best.as_ref()?, 1, log_evidence)
    }

    /// The answer of the first cause, if it is more probable than no gap.
    pub(super) fn proposal(&self, settings: &Settings) -> Option<Proposal> {
        let priors = Priors::of(settings, self.causes.len());
        let price = priors.worth(settings.temperature);
        self.first_answer().map(|answer| Proposal { answer, price })
    }

    /// What an answer leaves of the gap.
    pub(in crate::diagnose) fn lack_of_fit(&self, answer: &Answer) -> LackOfFit {
        let Searched { noise, is_coloured, .. } = &self.searched;
        lack_of_fit(answer, &self.refit, &self.base, noise, *is_coloured)
    }
}
