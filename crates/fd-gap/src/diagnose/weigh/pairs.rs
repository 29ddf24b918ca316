//! Second causes beside first ones.

use crate::together::each;

use super::{
    rank::{Basis, RankedCause},
    singles::Singles,
};
use crate::{
    diagnose::{
        candidates::is_free_curve,
        context::Context,
        monitor::{Stage, WithinAPiece},
        search::trial::Trial,
        sets::{EffectSet, Wanted, beside, to_come_near},
        settings::LEADING,
    },
    fit::FitError,
};

/// Pairs of simulated causes, the best first; none where the settings have no room for them.
pub(super) fn seek_pairs(singles: &Singles<'_>, context: &Context<'_>) -> Vec<EffectSet> {
    let monitor = context.monitor;
    if context.settings.two <= 0.0 {
        return Vec::new();
    }
    let trial = |ranked: &RankedCause| match ranked.basis {
        Basis::Simulation(id) => Some(singles.searched.trial(id)),
        Basis::Measurement(_) => None,
    };
    let best = singles.causes.iter().filter_map(trial);
    let best = best.filter(|trial| !is_free_curve(trial.candidate) && trial.best.is_some());
    let firsts: Vec<&Trial<'_>> = best.take(LEADING).collect();
    monitor.begin(Stage::Pairs, firsts.len());
    let found: Vec<Vec<EffectSet>> = each(&firsts, |first| {
        if monitor.is_stopped() {
            return Vec::new();
        }
        let pairs = second(first, singles, context).unwrap_or_default();
        monitor.advance();
        pairs
    });
    let mut all: Vec<EffectSet> = found.into_iter().flatten().collect();
    all.sort_by(|a, b| b.log_evidence.total_cmp(&a.log_evidence));
    let mut kept: Vec<EffectSet> = Vec::new();
    for pair in all {
        if !kept.iter().any(|known| known.is_of(&pair)) {
            kept.push(pair);
        }
    }
    kept
}

/// The best second causes beside a first one, as far as the two may come near the noise: far above it, pairs are no answer.
fn second(
    first: &Trial<'_>,
    singles: &Singles<'_>,
    context: &Context<'_>,
) -> Result<Vec<EffectSet>, FitError> {
    let Some(first) = EffectSet::single(first, &singles.reference) else { return Ok(Vec::new()) };
    let candidate = &|candidate: &_| !is_free_curve(candidate);
    let wanted = Wanted { candidate, least: to_come_near(&first, &singles.searched.noise) };
    let (settings, monitor) = (context.settings.for_one_law(), WithinAPiece(context.monitor));
    beside(
        &first,
        &wanted,
        singles,
        &Context { settings: &settings, monitor: &monitor, ..*context },
    )
}
