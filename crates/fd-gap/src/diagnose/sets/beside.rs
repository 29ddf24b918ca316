//! What can be added to a set of effects.

use std::sync::Arc;

use fd_effect::{Candidate, Kind, SiteRef};
use fd_sim::model::Model;

use super::{
    EffectSet,
    set::{in_step, offers},
};
use crate::{
    diagnose::{
        candidates::{Candidates, is_same_cause},
        context::Context,
        prepare::{Prepared, noise::KnownNoise},
        search::search_beside,
        weigh::{answer::Fit, singles::Singles},
    },
    fit::{FitError, NullFit, Problem},
    quality::REACHED,
};

/// What is sought beside a set.
#[derive(Clone, Copy)]
pub struct Wanted<'a> {
    /// Whether a candidate is.
    pub candidate: &'a dyn Fn(&Candidate) -> bool,
    /// What it must take of the squares that are left.
    pub least: f64,
}

/// The set with one more effect each, the most evidence first: all laws of the most promising causes.
pub(in crate::diagnose) fn beside(
    set: &EffectSet,
    wanted: &Wanted<'_>,
    singles: &Singles<'_>,
    context: &Context<'_>,
) -> Result<Vec<EffectSet>, FitError> {
    let null = &singles.searched.null.problem;
    // What is in the set is one more nuisance.
    let Fit { problem, minimum } = &set.fit;
    let plan = null.plan().with_parameters(problem.effects());
    let (simulator, weights) = (problem.simulator().boxed(), null.weights().clone());
    let mut problem = Problem::new(Arc::new(plan), simulator, vec![], weights)?;
    let minimum = minimum.with_slopes(&mut problem).ok_or(FitError::Diverged)?;
    let base = NullFit { minimum: minimum.shared(&problem), problem };
    let nominal = context.case.nominal.model();
    let is_new = |c: &Candidate| {
        let is_known = set.members.iter().any(|member| is_same_cause(member, c));
        c.kind == Kind::Simulation && !is_known && is_of_the_plant(&c.site, nominal)
    };
    let offers = offers(context.case.suspects, &set.members);
    let simulated = offers.into_iter().flatten().filter(|c| is_new(c) && (wanted.candidate)(c));
    let simulated = simulated.map(|candidate| in_step(candidate, set.model.step)).collect();
    let candidates = Candidates { simulated, measured: Vec::new(), refused: Vec::new() };
    let (model, noise) = (set.model.clone(), singles.searched.noise.clone());
    let prepared = Prepared { model, null: base, noise };
    let context = Context { candidates: &candidates, ..*context };
    let remembered = Arc::clone(&singles.searched.changes);
    let searched = search_beside(prepared, wanted.least, remembered, &context)?;
    let finals = searched.trials.iter().filter(|trial| trial.is_final);
    let mut sets: Vec<EffectSet> = finals.filter_map(|trial| set.with(trial, singles)).collect();
    sets.sort_by(|a, b| b.log_evidence.total_cmp(&a.log_evidence));
    Ok(sets)
}

/// An error of a parameter of an effect is no cause.
fn is_of_the_plant(site: &SiteRef, nominal: &Model) -> bool {
    match site {
        SiteRef::Parameter(_, name) => nominal.parameter(name).is_some(),
        _ => true,
    }
}

/// What a cause must take of the squares that a set leaves, to come where likelihoods are of use.
pub(in crate::diagnose) fn to_come_near(set: &EffectSet, noise: &KnownNoise) -> f64 {
    let farness = set.errors().map_or(1.0, |errors| noise.reach(&errors) / REACHED);
    to_take(set.cost(), farness)
}

/// What has to be taken of squares that are so many times as far from the noise as likelihoods are of use.
fn to_take(squares: f64, farness: f64) -> f64 {
    squares * (1.0 - farness.max(1.0).powi(-2))
}

#[cfg(test)]
mod tests {
    use super::to_take;

    #[test]
    #[expect(clippy::float_cmp, reason = "powers of two are exact")]
    fn a_further_cause_takes_what_is_far_from_the_noise() {
        assert_eq!(to_take(64.0, 0.5), 0.0);
        assert_eq!(to_take(64.0, 1.0), 0.0);
        assert_eq!(to_take(64.0, 4.0), 60.0);
    }
}
