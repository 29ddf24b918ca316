//! The best explanation comes near the noise: likelihoods speak.

use super::{
    beside::Beside,
    judged::{Judged, NamedPairs},
    pair_ties::name_pairs,
    probabilities::{Believed, believe, bounded, unknown_gain},
    ties::ties,
    verdict::verdict,
};
use crate::diagnose::{
    context::Context,
    result::{Regime, Verdict},
    sets::EffectSet,
    weigh::{Weighed, rank::Basis, singles::Singles},
};

/// Judges by evidence. Something unknown is the more probable, the more the best explanation leaves
/// beyond noise, and the more wrong samples come in bursts.
pub(super) fn by_evidence<'a>(weighed: Weighed<'a>, context: &Context<'a>) -> Judged<'a> {
    let settings = context.settings;
    let Weighed { singles, pairs: fitted, best: simulated, lack_of_fit } = weighed;
    let ties = ties(&singles.causes, &singles.searched, settings);
    let simulated_effects = simulated.effects;
    let beside = Beside::of(&singles, &simulated, context.candidates);
    let (best, lack_of_fit, doubt, third) = match beside.as_ref().filter(|b| b.is_best(&fitted)) {
        Some(Beside { measured, .. }) => {
            let best = simulated.with(measured);
            let lack_of_fit = singles.lack_of_fit(&best);
            let third = if simulated_effects == 2 { measured.gain } else { 0.0 };
            (best, lack_of_fit, measured.doubt(), third)
        }
        None => (simulated, lack_of_fit, doubt_of_first(&singles), 0.0),
    };
    let measured =
        beside.map_or_else(Vec::new, |beside| beside.with_ties(&singles.causes, &ties.tied));
    let is_curve = match (best.effects, simulated_effects) {
        (1, _) => singles.does_first_follow_anything(),
        (_, 2) => fitted.first().is_some_and(EffectSet::follows_anything),
        _ => false,
    };
    let NamedPairs { pairs, tied, fitted } =
        name_pairs(fitted, third, measured, &singles.causes, settings);
    let gain = unknown_gain(&lack_of_fit.leftover) + doubt;
    let Believed { others: probabilities, causes, pairs } = bounded(
        believe(singles.causes, pairs, &best, gain, settings),
        &lack_of_fit,
        doubt,
        is_curve,
    );
    let pairs = NamedPairs { pairs, tied, fitted };
    let singles = Singles { causes, ..singles };
    let verdict = verdict(probabilities, &singles.causes, &ties, &pairs);
    let is_one = matches!(verdict, Verdict::Cause | Verdict::Tied);
    // Named alone, whatever else may be there: what is said of it is said of it alone.
    let alone = singles.first_answer().filter(|_| is_one && simulated_effects == 2);
    let (best, lack_of_fit) = match alone {
        Some(alone) => {
            let lack_of_fit = singles.lack_of_fit(&alone);
            (alone, lack_of_fit)
        }
        None => (best, lack_of_fit),
    };
    Judged {
        verdict,
        regime: Regime::AtTheFloor,
        probabilities,
        singles,
        ties,
        pairs,
        best,
        lack_of_fit,
        horizons: settings.report_horizons.clone(),
        windows: None,
    }
}

/// Log-likelihood that something unknown could gain over the first cause if that is one of the
/// measurement.
fn doubt_of_first(singles: &Singles<'_>) -> f64 {
    match singles.causes.first().map(|first| first.basis) {
        Some(Basis::Measurement(id)) => singles.measured(id).doubt(),
        Some(Basis::Simulation(_)) | None => 0.0,
    }
}
