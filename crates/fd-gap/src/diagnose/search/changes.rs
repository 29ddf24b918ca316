//! What candidates change, remembered from one look at them to the next.
//!
//! How an effect moves the outputs depends little on what else is missing. So what is sought beside other effects is judged by
//! the changes that were seen without these, and only what promises most by them is simulated again.

use std::collections::HashMap;

use fd_effect::{Candidate, SiteRef};

use super::{
    change::Change,
    screened::{Screened, of_causes},
};
use crate::{
    fit::{LONG, LeastSquares, NullFit, Surroundings},
    together::each,
};

/// Causes that are looked at again beside others.
const AGAIN: usize = 20;

/// The changes of the residuals, which are white, from where effects are absent to their best starts.
#[derive(Debug)]
pub(in crate::diagnose) struct Changes {
    /// The noise that they are in units of.
    sigma: Vec<f64>,
    of: HashMap<Law, Vec<Change>>,
}

/// Label, site, partner and law of a candidate.
type Law = (&'static str, SiteRef, Option<SiteRef>, &'static str);

impl Changes {
    /// Those of what was screened beside `null`; `None` where that is too much, or where residuals are not white.
    pub(super) fn of(null: &NullFit, screened: &mut [Screened<'_>]) -> Option<Self> {
        let weights = null.problem.weights();
        let is_white = weights.colour.iter().all(|colour| colour.order() == 0);
        if !is_white || LONG < null.problem.layout().residuals() {
            return None;
        }
        let mut of = HashMap::new();
        // What rounding does has no size, but a phase: it is always looked at.
        for Screened { candidate, scored, .. } in
            screened.iter_mut().filter(|one| one.candidate.rounding.is_none())
        {
            let changes = scored.iter_mut().map(|start| std::mem::take(&mut start.change));
            let seen = changes.filter(|change| !change.residuals.is_empty());
            of.insert(law(candidate), seen.collect());
        }
        Some(Self { sigma: weights.sigma.clone(), of })
    }

    /// Which candidates are laws of the causes that promise most, or of one of which nothing is known.
    pub(super) fn promising(
        &self,
        candidates: &[Candidate],
        null: &NullFit,
        around: &Surroundings<'_>,
    ) -> Vec<bool> {
        let promise = |candidate: &Candidate| {
            let Some(changes) = self.of.get(&law(candidate)) else { return f64::INFINITY };
            let gain = |change: &Change| {
                let residuals = null.problem.reweighed(&change.residuals, &self.sigma);
                let score = around.score(&residuals, change.range);
                score.map_or(0.0, |score| around.left() - score.left)
            };
            changes.iter().map(gain).fold(0.0, f64::max)
        };
        let (promises, ranked) = of_causes(candidates.iter().zip(each(candidates, promise)));
        let least = ranked.into_iter().filter(|promise| promise.is_finite()).nth(AGAIN - 1);
        promises.into_iter().map(|promise| least.is_none_or(|least| least <= promise)).collect()
    }
}

fn law(candidate: &Candidate) -> Law {
    let (label, site, partner) = candidate.identity();
    (label, site.clone(), partner.cloned(), candidate.law)
}
