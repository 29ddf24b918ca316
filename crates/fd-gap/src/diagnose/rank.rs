//! Evidence of trials, pooled over the laws of a cause, and probabilities.

use super::{
    explain::settle,
    result::{Cause, Estimate, Group},
    settings::Settings,
    trial::Trial,
};
use crate::{
    effect::Side,
    evidence::{evidence, likelihood, pool, posterior},
    shrink::gap,
};

/// What the noise is taken to be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noise<'a> {
    /// Spread of `ln` of the noise of each output.
    pub(super) spread: &'a [f64],
    /// Whether it may have a colour.
    pub(super) is_coloured: bool,
    /// Logarithm of the evidence of "no gap".
    pub(super) reference: f64,
}

/// Probability of "no gap", and the causes with the place of their best law among the trials, the
/// most probable first.
pub(super) fn rank(
    trials: &mut [Trial<'_>],
    noise: Noise<'_>,
    settings: &Settings,
) -> (f64, Vec<(usize, Cause)>) {
    let mut groups: Vec<(Vec<usize>, Vec<f64>)> = Vec::new();
    let mut laws: Vec<(f64, f64, f64)> = Vec::with_capacity(trials.len());
    for i in 0..trials.len() {
        laws.push(trials[i].weigh(noise));
        let same =
            |(members, _): &&mut (Vec<usize>, Vec<f64>)| trials[members[0]].is_of(&trials[i]);
        match groups.iter_mut().find(same) {
            Some((members, weights)) => {
                members.push(i);
                weights.push(laws[i].0);
            }
            None => groups.push((vec![i], vec![laws[i].0])),
        }
    }
    let pooled: Vec<f64> = groups.iter().map(|(_, weights)| pool(weights)).collect();
    let probabilities = posterior(&pooled, settings.no_gap, settings.temperature);
    let mut causes: Vec<(usize, Cause)> = groups
        .iter()
        .enumerate()
        .map(|(g, (members, _))| {
            let heaviest = |a: &&usize, b: &&usize| laws[**a].0.total_cmp(&laws[**b].0);
            let best = members.iter().max_by(heaviest).copied().unwrap_or(members[0]);
            let cause = trials[best].cause(laws[best], pooled[g], probabilities.causes[g]);
            (best, cause)
        })
        .collect();
    causes.sort_by(|(_, a), (_, b)| b.log_evidence.total_cmp(&a.log_evidence));
    (probabilities.no_gap, causes)
}

/// Sums of probabilities over mechanisms at places.
pub(super) fn groups(causes: &[Cause]) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for (place, cause) in causes.iter().enumerate() {
        let same = |group: &&mut Group| group.family == cause.family && group.site == cause.site;
        if let Some(group) = groups.iter_mut().find(same) {
            group.probability += cause.probability;
            group.causes.push(place);
        } else {
            groups.push(Group {
                family: cause.family,
                site: cause.site.clone(),
                side: cause.side,
                probability: cause.probability,
                causes: vec![place],
            });
        }
    }
    groups.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    groups
}

/// Sums of probabilities over sides of the plant.
pub(super) fn sides(causes: &[Cause]) -> Vec<(Side, f64)> {
    let of = |side| {
        let causes = causes.iter().filter(|cause| cause.side == side);
        (side, causes.map(|cause| cause.probability).sum())
    };
    let mut sides: [(Side, f64); 3] = [Side::Input, Side::Dynamics, Side::Output].map(of);
    sides.sort_by(|a, b| b.1.total_cmp(&a.1));
    sides.to_vec()
}

impl Trial<'_> {
    /// Errors in units of sigma.
    pub(super) fn errors(&mut self) -> Option<Vec<Vec<Vec<f64>>>> {
        let best = self.best.as_ref()?;
        self.problem.errors(&best.z)
    }

    /// Whether both are laws of one cause.
    fn is_of(&self, other: &Trial<'_>) -> bool {
        let (a, b) = (self.candidate, other.candidate);
        a.label == b.label && a.site == b.site && a.partner == b.partner
    }

    /// Evidence over that of "no gap", gap, and the noise in sigma.
    fn weigh(&mut self, noise: Noise<'_>) -> (f64, f64, f64) {
        let hopeless = (f64::NEG_INFINITY, f64::NAN, 1.0);
        let Some(errors) = self.errors() else { return hopeless };
        let Some(best) = &self.best else { return hopeless };
        let likelihood = likelihood(&errors, noise.spread, noise.is_coloured);
        let scale = likelihood.scale.iter().copied().fold(0.0, f64::max);
        match evidence(&self.problem, best, &likelihood, &self.strengths) {
            Some(evidence) => (evidence - noise.reference, gap(&errors), scale),
            None => hopeless,
        }
    }

    fn cause(
        &self,
        (_, gap, scale): (f64, f64, f64),
        log_evidence: f64,
        probability: f64,
    ) -> Cause {
        let candidate = self.candidate;
        let values = self.best.as_ref().map(|best| self.problem.effect_values(&best.z));
        let deviations =
            self.best.as_ref().and_then(|best| self.problem.standard_errors(best, scale));
        let parameters = candidate.parameters.iter().enumerate().map(|(i, p)| Estimate {
            name: p.name.clone(),
            unit: p.unit.clone(),
            value: values.as_ref().map_or(f64::NAN, |values| values[i]),
            standard_error: deviations.as_ref().map_or(f64::NAN, |d| d[i]),
            is_strength: p.is_strength,
            is_reciprocal: p.is_reciprocal,
        });
        Cause {
            label: candidate.label,
            site: candidate.site.clone(),
            partner: candidate.partner.clone(),
            family: candidate.family,
            side: candidate.side,
            probability,
            log_evidence,
            law: candidate.law,
            parameters: parameters.collect(),
            gap,
            model: self.best.as_ref().map_or_else(
                || candidate.model.clone(),
                |best| settle(&candidate.model, &self.problem, &best.z),
            ),
        }
    }
}
