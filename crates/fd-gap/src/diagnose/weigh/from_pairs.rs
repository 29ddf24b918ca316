//! Single causes fitted again from where pairs have them.

use crate::together::each;

use super::singles::{Singles, weigh_singles};
use crate::{
    diagnose::{
        candidates::is_same_cause,
        context::Context,
        search::{searched::Searched, trial::Trial},
        sets::{EffectSet, Member},
        settings::LEADING,
    },
    fit::FitError,
};

/// The same causes, fitted again from where the best pairs have them: one of two may be next to
/// nothing, and the other have found beside it what it did not find alone. They are weighed again if
/// any came out better.
pub(super) fn fitted_from<'a>(
    pairs: &[EffectSet],
    singles: Singles<'a>,
    context: &Context<'a>,
) -> Result<Singles<'a>, FitError> {
    let Searched { null, mut trials, .. } = singles.searched;
    let known: Vec<(Member<'_>, Vec<f64>)> = pairs.iter().take(LEADING).flat_map(of_pair).collect();
    let fit_again = |trial: &mut Trial<'_>| {
        let is_better = known
            .iter()
            .filter(|(member, _)| is_same_cause(member.candidate, trial.candidate))
            .filter(|(member, _)| member.candidate.law == trial.candidate.law)
            .filter(|(member, nuisances)| trial.warm_start_at(nuisances, &member.values))
            .count();
        if 0 < is_better {
            trial.full_fit(&null);
        }
        0 < is_better
    };
    let are_better = each(&mut trials, fit_again).contains(&true);
    let searched = Searched { null, trials, ..singles.searched };
    if are_better {
        weigh_singles(searched, context.candidates)
    } else {
        Ok(Singles { searched, ..singles })
    }
}

/// The members of a pair, and what the nuisances are there.
fn of_pair(pair: &EffectSet) -> impl Iterator<Item = (Member<'_>, Vec<f64>)> {
    let nuisances = pair.nuisances();
    pair.members().into_iter().map(move |member| (member, nuisances.clone()))
}
