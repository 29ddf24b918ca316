//! The causes and pairs that a stand-in proposes.

use std::collections::HashSet;

use fd_effect::{Candidate, EffectParameter, Kind, Offers, Side, SiteRef, Suspects};
use fd_sim::model::Model;

use super::effort::Effort;
use crate::{
    diagnose::{Cause, Diagnosis},
    evidence::grades::STRONG,
};

/// Causes that cannot be told from the best one are confirmed up to so many times the usual number.
const AS_MANY: usize = 2;

/// Best causes of which all laws are tried: one may be right where another only comes near.
const ALL_LAWS: usize = 3;

/// Whether a candidate is a limit of what moves the plant, or of its motion.
fn is_limit(candidate: &Candidate) -> bool {
    candidate.side != Side::Output
        && candidate.parameters.iter().any(|p| p.is_strength && p.is_reciprocal)
}

/// The best causes and pairs of a diagnosis, each with its best law and the values that were found; the first few
/// with their other laws as well.
#[derive(Debug)]
pub(super) struct Proposals<'a> {
    suspects: &'a dyn Suspects,
    singles: Vec<Proposal>,
    pairs: Vec<[Proposal; 2]>,
    /// Causes that are limits and tried as they are.
    limits: usize,
}

/// A law of a cause, with the model in which its parameters have the values that were found.
#[derive(Debug)]
struct Proposal {
    label: &'static str,
    law: &'static str,
    site: SiteRef,
    partner: Option<SiteRef>,
    model: Model,
}

impl Proposal {
    fn of(cause: &Cause) -> Self {
        let Cause { label, law, site, partner, model, .. } = cause.clone();
        Self { label, law, site, partner, model }
    }

    fn is_of(&self, candidate: &Candidate) -> bool {
        candidate.identity() == (self.label, &self.site, self.partner.as_ref())
    }

    fn is_of_law(&self, candidate: &Candidate) -> bool {
        self.is_of(candidate) && candidate.law == self.law
    }

    /// The candidate, started from the values that were found; of another law, from its own starts as well.
    fn started(&self, candidate: Candidate) -> Candidate {
        let found = |p: &EffectParameter| {
            let known = self.model.parameters.iter().find(|known| known.name == p.name);
            known.map_or(p.neutral, |known| known.value).clamp(p.low, p.high)
        };
        let mut starts = vec![candidate.parameters.iter().map(found).collect()];
        if !self.is_of_law(&candidate) {
            starts.extend(candidate.starts);
            return Candidate { starts, ..candidate };
        }
        Candidate { starts, spectral: None, ..candidate }
    }
}

impl<'a> Proposals<'a> {
    /// The proposals of a diagnosis of these suspects.
    pub(super) fn of(diagnosis: &Diagnosis, suspects: &'a dyn Suspects, effort: Effort) -> Self {
        let pairs: Vec<[Proposal; 2]> = diagnosis
            .pairs
            .iter()
            .take(effort.pairs)
            .map(|pair| pair.causes.each_ref().map(Proposal::of))
            .collect();
        // Halves of pairs are singles, too, for a pair is tried beside one.
        let is_half = |cause: &Cause| {
            pairs.iter().flatten().any(|half| {
                (half.label, &half.site, &half.partner)
                    == (cause.label, &cause.site, &cause.partner)
            })
        };
        let best = diagnosis.causes.first().map_or(0.0, |first| first.log_evidence.max(0.0));
        let is_near = |cause: &Cause| best - STRONG < cause.log_evidence;
        let causes = diagnosis.causes.iter().enumerate();
        let chosen = causes.filter(|(place, cause)| {
            *place < effort.causes
                || *place < AS_MANY * effort.causes && is_near(cause)
                || is_half(cause)
        });
        let singles = chosen.map(|(_, cause)| Proposal::of(cause)).collect();
        Self { suspects, singles, pairs, limits: 0 }
    }

    /// The same and all limits before the plant or in it, from their own starts; `None` where there are none. What is
    /// behind the plant is no matter of its slopes.
    pub(super) fn with_limits(self) -> Option<Self> {
        let offers = self.suspects.alone();
        let all = offers.iter().flatten().filter(|candidate| is_limit(candidate));
        let limits = all.map(Candidate::identity).collect::<HashSet<_>>().len();
        (0 < limits).then_some(Self { limits, ..self })
    }

    /// How many causes are limits that are tried as they are.
    pub(super) fn limits(&self) -> usize {
        self.limits
    }
}

impl Suspects for Proposals<'_> {
    fn alone(&self) -> Offers {
        let offers = self.suspects.alone().into_iter();
        let each = offers.filter_map(|offer| match offer {
            // A distribution costs no run.
            Ok(candidate) if candidate.kind != Kind::Simulation => Some(Ok(candidate)),
            Ok(candidate) if 0 < self.limits && is_limit(&candidate) => Some(Ok(candidate)),
            Ok(candidate) => {
                let proposal = self.singles.iter().enumerate().find(|(place, proposal)| {
                    proposal.is_of_law(&candidate)
                        || *place < ALL_LAWS && proposal.is_of(&candidate)
                });
                // Beside what starts where it was found, a limit that starts anywhere promises nothing.
                let is_plain = 0 < self.limits;
                proposal.map(|(_, proposal)| {
                    Ok(if is_plain { candidate } else { proposal.started(candidate) })
                })
            }
            Err(refused) => Some(Err(refused)),
        });
        each.collect()
    }

    fn beside(&self, first: &Candidate) -> Offers {
        let others: Vec<&Proposal> = self
            .pairs
            .iter()
            .flat_map(|[a, b]| [[a, b], [b, a]])
            .filter(|[one, _]| one.is_of(first))
            .map(|[_, other]| other)
            .collect();
        if others.is_empty() {
            return Vec::new();
        }
        let offers = self.suspects.beside(first).into_iter().flatten();
        let each = offers.filter_map(|candidate| {
            let proposal = others.iter().find(|proposal| proposal.is_of_law(&candidate))?;
            Some(Ok(proposal.started(candidate)))
        });
        each.collect()
    }
}
