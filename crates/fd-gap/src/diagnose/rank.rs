//! Evidence of trials, pooled over the laws of a cause; sums over mechanisms and sides.

use fd_effect::{Candidate, Side, map::mechanism};

use super::{
    explain::settle,
    observe::Observed,
    result::{Cause, CauseId, Estimate, Explanation, Group, Pair, SideShare},
    trial::Trial,
};
use crate::{
    evidence::{NoisePrior, evidence, likelihood, pool},
    fit::{Minimum, Problem},
    shrink::gap,
};

/// What evidence is measured against.
#[derive(Clone, Copy, Debug)]
pub(super) struct Yardstick<'a> {
    /// The noise of each output, as an unknown.
    pub(super) noise: &'a [NoisePrior],
    /// Logarithm of the evidence of "no gap".
    pub(super) reference: f64,
}

/// A law with its weight.
#[derive(Clone, Debug)]
pub(super) struct Weighed<'a> {
    candidate: &'a Candidate,
    /// Place among the trials; `None` for a law of the measurement.
    trial: Option<usize>,
    /// Logarithm of the evidence over that of "no gap".
    log_evidence: f64,
    pub(super) cause: Cause,
}

/// The causes and the trial of the best law of each, the most evidence first.
pub(super) type Ranking = Vec<(Option<usize>, Cause)>;

/// Pools the evidence of laws over causes. `observed` are causes of the measurement, next to the
/// `refit`ted nominal model. Probabilities come later.
pub(super) fn rank(
    trials: &mut [Trial<'_>],
    observed: &[(&Candidate, Observed)],
    refit: &Explanation,
    yardstick: Yardstick<'_>,
) -> Ranking {
    let mut laws: Vec<Weighed<'_>> = Vec::with_capacity(trials.len() + observed.len());
    for (i, trial) in trials.iter_mut().enumerate() {
        laws.push(trial.weigh(i, yardstick));
    }
    laws.extend(observed.iter().map(|(candidate, observed)| Weighed {
        candidate,
        trial: None,
        log_evidence: observed.gain,
        cause: observed_cause(candidate, observed, refit),
    }));
    let mut causes: Vec<Vec<Weighed<'_>>> = Vec::new();
    for law in laws {
        match causes.iter_mut().find(|known| is_same(known[0].candidate, law.candidate)) {
            Some(known) => known.push(law),
            None => causes.push(vec![law]),
        }
    }
    let pooled = causes.into_iter().filter_map(|laws| {
        let evidence: Vec<f64> = laws.iter().map(|law| law.log_evidence).collect();
        let heaviest = |a: &Weighed<'_>, b: &Weighed<'_>| a.log_evidence.total_cmp(&b.log_evidence);
        let best = laws.into_iter().max_by(heaviest)?;
        Some((best.trial, Cause { log_evidence: pool(&evidence), ..best.cause }))
    });
    let mut ranking: Ranking = pooled.collect();
    ranking.sort_by(|(_, a), (_, b)| b.log_evidence.total_cmp(&a.log_evidence));
    ranking
}

/// Whether both are laws of one cause.
pub(super) fn is_same(a: &Candidate, b: &Candidate) -> bool {
    a.identity() == b.identity()
}

/// A cause of the measurement, next to a model that stays as it is.
pub(super) fn observed_cause(
    candidate: &Candidate,
    observed: &Observed,
    explanation: &Explanation,
) -> Cause {
    let squares: f64 = explanation.gap.iter().map(|gap| gap * gap).sum();
    Cause {
        label: candidate.label,
        site: candidate.site.clone(),
        partner: candidate.partner.clone(),
        family: candidate.family,
        side: candidate.side,
        probability: 0.0,
        log_evidence: observed.gain,
        law: candidate.law,
        parameters: observed.parameters.clone(),
        gap: f64::sqrt(squares / explanation.gap.len().max(1) as f64),
        model: explanation.model.clone(),
    }
}

/// Probabilities that mechanisms at places are at work, alone or as one of two.
pub(super) fn groups(causes: &[Cause], pairs: &[Pair]) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    let is_of =
        |group: &Group, cause: &Cause| group.family == cause.family && group.site == cause.site;
    for (place, cause) in causes.iter().enumerate() {
        if let Some(group) = groups.iter_mut().find(|group| is_of(group, cause)) {
            group.probability += cause.probability;
            group.causes.push(CauseId(place));
        } else {
            groups.push(Group {
                family: cause.family,
                site: cause.site.clone(),
                side: cause.side,
                probability: cause.probability,
                causes: vec![CauseId(place)],
            });
        }
    }
    for group in &mut groups {
        let with = pairs.iter().filter(|pair| pair.causes.iter().any(|cause| is_of(group, cause)));
        group.probability += with.map(|pair| pair.probability).sum::<f64>();
    }
    groups.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    groups
}

/// Probabilities that something is at work on a side of the plant.
pub(super) fn sides(causes: &[Cause], pairs: &[Pair]) -> Vec<SideShare> {
    let of = |side| {
        let alone = causes.iter().filter(|cause| cause.side == side).map(|cause| cause.probability);
        let is_there = |pair: &&Pair| pair.causes.iter().any(|cause| cause.side == side);
        let paired = pairs.iter().filter(is_there).map(|pair| pair.probability);
        SideShare { side, probability: alone.chain(paired).sum() }
    };
    let mut sides = [Side::Input, Side::Dynamics, Side::Output].map(of);
    sides.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    sides.to_vec()
}

impl<'a> Trial<'a> {
    /// Evidence over that of "no gap", and everything else that there is to say.
    pub(super) fn weigh(&mut self, place: usize, yardstick: Yardstick<'_>) -> Weighed<'a> {
        let weight = self.best.clone().and_then(|best| {
            let errors = self.problem.errors_at(&best);
            let likelihood = likelihood(&errors, yardstick.noise);
            let scale = likelihood.scale.iter().copied().fold(0.0, f64::max);
            let found = evidence(&self.problem, &best, &likelihood, &[&self.strengths])?;
            let part = estimates(self.candidate, &self.problem, &best, scale, 0);
            Some((found - yardstick.reference, gap(&errors), part))
        });
        let (log_evidence, gap, parameters) =
            weight.unwrap_or((f64::NEG_INFINITY, f64::NAN, Vec::new()));
        let model = match &self.best {
            Some(best) => settle(&self.model, &self.problem, &best.z),
            None => self.model.clone(),
        };
        let Candidate { label, law, site, partner, side, .. } = self.candidate.clone();
        let cause = Cause {
            label,
            site,
            partner,
            family: mechanism(self.candidate),
            side,
            probability: 0.0,
            log_evidence,
            law,
            parameters,
            gap,
            model,
        };
        Weighed { candidate: self.candidate, trial: Some(place), log_evidence, cause }
    }
}

/// Fitted parameters of a candidate, of which the first has place `first` among the effects.
pub(super) fn estimates(
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
