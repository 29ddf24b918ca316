//! Evidence of trials, pooled over the laws of a cause.

use fd_effect::{Candidate, NATIVE, map::mechanism};

use super::{explain::settle, measurement::MeasurementCause};
use crate::{
    diagnose::{
        candidates::is_same_cause,
        result::{Cause, Estimate, Explanation},
        search::{searched::TrialId, trial::Trial},
    },
    evidence::{NoisePrior, evidence, grades::BARE_MENTION, likelihood, pool},
    fit::{Minimum, Problem},
    shrink::gap,
};

/// What evidence is measured against: "no gap".
#[derive(Clone, Debug)]
pub(in crate::diagnose) struct Reference {
    /// The noise of each output, as an unknown.
    pub noise: Vec<NoisePrior>,
    /// Logarithm of the evidence of "no gap".
    pub log_evidence: f64,
}

/// What a cause rests on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::diagnose) enum Basis {
    /// The fit of its best law.
    Simulation(TrialId),
    /// A change of the measurement beside the refitted model.
    Measurement(MeasurementId),
}

/// A cause of the measurement: its place among those that were weighed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::diagnose) struct MeasurementId(pub(super) usize);

/// A cause with what it rests on.
#[derive(Clone, Debug)]
pub(in crate::diagnose) struct RankedCause {
    pub basis: Basis,
    pub cause: Cause,
}

/// A law with its weight.
#[derive(Debug)]
pub(in crate::diagnose) struct WeighedLaw<'a> {
    candidate: &'a Candidate,
    basis: Basis,
    /// The cause with this law alone.
    pub cause: Cause,
}

impl WeighedLaw<'_> {
    /// What decides which law speaks for its cause.
    fn preference(&self) -> f64 {
        // The file of the simulator can keep a law that it has in itself.
        let is_native = self.candidate.law == NATIVE;
        self.cause.log_evidence + if is_native { BARE_MENTION } else { 0.0 }
    }
}

/// Pools the evidence of laws over causes, the most evidence first. `measured` are causes of the
/// measurement, next to the `refit`ted nominal model. Probabilities come later.
pub(super) fn rank<'a>(
    laws: impl Iterator<Item = WeighedLaw<'a>>,
    measured: &[MeasurementCause<'a>],
    refit: &Explanation,
) -> Vec<RankedCause> {
    let mut causes: Vec<Vec<WeighedLaw<'_>>> = Vec::new();
    for law in laws.chain(measured_laws(measured, refit)) {
        match causes.iter_mut().find(|known| is_same_cause(known[0].candidate, law.candidate)) {
            Some(known) => known.push(law),
            None => causes.push(vec![law]),
        }
    }
    let pooled = causes.into_iter().filter_map(|laws| {
        let evidence: Vec<f64> = laws.iter().map(|law| law.cause.log_evidence).collect();
        let heaviest =
            |a: &WeighedLaw<'_>, b: &WeighedLaw<'_>| a.preference().total_cmp(&b.preference());
        let WeighedLaw { basis, cause, .. } = laws.into_iter().max_by(heaviest)?;
        Some(RankedCause { basis, cause: Cause { log_evidence: pool(&evidence), ..cause } })
    });
    let mut ranking: Vec<RankedCause> = pooled.collect();
    ranking.sort_by(|a, b| b.cause.log_evidence.total_cmp(&a.cause.log_evidence));
    ranking
}

/// Laws of the measurement; all laws of a cause rest on the first of them.
fn measured_laws<'a>(
    measured: &[MeasurementCause<'a>],
    refit: &Explanation,
) -> impl Iterator<Item = WeighedLaw<'a>> {
    measured.iter().map(move |law| {
        let is_same = |other: &MeasurementCause<'_>| is_same_cause(other.candidate, law.candidate);
        let first = measured.iter().position(is_same).unwrap_or_default();
        let basis = Basis::Measurement(MeasurementId(first));
        WeighedLaw { candidate: law.candidate, basis, cause: measured_cause(law, refit) }
    })
}

/// A cause of the measurement, next to a model that stays as it is.
pub(in crate::diagnose) fn measured_cause(
    measured: &MeasurementCause<'_>,
    explanation: &Explanation,
) -> Cause {
    let candidate = measured.candidate;
    let squares: f64 = explanation.gap.iter().map(|gap| gap * gap).sum();
    Cause {
        label: candidate.label,
        site: candidate.site.clone(),
        partner: candidate.partner.clone(),
        family: candidate.family,
        side: candidate.side,
        probability: 0.0,
        log_evidence: measured.gain,
        law: candidate.law,
        parameters: measured.parameters.clone(),
        gap: f64::sqrt(squares / explanation.gap.len().max(1) as f64),
        model: explanation.model.clone(),
    }
}

/// Evidence of a fitted law over that of "no gap", and everything else that there is to say.
pub(in crate::diagnose) fn weigh_law<'a>(
    id: TrialId,
    trial: &mut Trial<'a>,
    reference: &Reference,
) -> WeighedLaw<'a> {
    let weight = trial.best.clone().and_then(|best| {
        let errors = trial.problem.errors_at(&best)?;
        let likelihood = likelihood(&errors, &reference.noise);
        let scale = likelihood.scale.iter().copied().fold(0.0, f64::max);
        let found = evidence(&trial.problem, &best, &likelihood, &[&trial.strengths])?;
        let part = estimates(trial.candidate, &trial.problem, &best, scale, 0);
        Some((found - reference.log_evidence, gap(&errors), part))
    });
    let (log_evidence, gap, parameters) =
        weight.unwrap_or((f64::NEG_INFINITY, f64::NAN, Vec::new()));
    let model = match &trial.best {
        Some(best) => settle(&trial.model, &trial.problem, &best.z),
        None => trial.model.clone(),
    };
    let Candidate { label, law, site, partner, side, .. } = trial.candidate.clone();
    let cause = Cause {
        label,
        site,
        partner,
        family: mechanism(trial.candidate),
        side,
        probability: 0.0,
        log_evidence,
        law,
        parameters,
        gap,
        model,
    };
    WeighedLaw { candidate: trial.candidate, basis: Basis::Simulation(id), cause }
}

/// Fitted parameters of a candidate, of which the first has place `first` among the effects.
pub(in crate::diagnose) fn estimates(
    candidate: &Candidate,
    problem: &Problem,
    at: &Minimum,
    scale: f64,
    first: usize,
) -> Vec<Estimate> {
    let values = problem.effect_values(&at.z);
    let deviations = problem.standard_errors(at, scale);
    let parameters = candidate.parameters.iter().enumerate().map(|(i, p)| Estimate {
        name: p.name.clone(),
        unit: p.unit.clone(),
        value: values[first + i],
        standard_error: deviations.as_ref().map_or(f64::NAN, |d| d[first + i]),
        is_strength: p.is_strength,
        is_reciprocal: p.is_reciprocal,
    });
    parameters.collect()
}
