//! The one place where the blind test calls the diagnosis.

use std::time::Instant;

use fd_effect::{EverySite, Side, Suspects, library, with_default_sites};
use fd_gap::{
    diagnose::{self, Cause, Pair, Settings, Verdict, diagnose},
    fit::Horizon,
    road::road,
};
use fd_model::Record;
use fd_sim::{model::Model, simulate::Nominal};
use fdiag::gap_study::follow;

use super::{
    answer::{Answer, Named, Share, Together, UNCLEAR},
    error::BlindError,
};

/// Causes that are kept in an answer.
const KEPT: usize = 20;
/// Most causes that are sought one after another, as for a user.
const MOST: usize = 8;
/// Weight of what is left above the floor, against the probability of "none of these".
const TIE_BREAK: f64 = 1e-3;

/// Diagnoses a case as a user would.
pub(super) fn answer(
    name: &str,
    model: &Model,
    train: &Record,
    held_out: &Record,
    settings: &Settings,
) -> Result<Answer, BlindError> {
    let begun = Instant::now();
    let model = with_default_sites(model);
    let (mut logs, mut held_out) = ([train.clone()], [held_out.clone()]);
    let mut settings = settings.clone();
    let follower = follow(&model, &logs)?;
    let nominal: &dyn Nominal = match &follower {
        Some(follower) => {
            for record in logs.iter_mut().chain(&mut held_out) {
                // A record of this model can be followed.
                if let Ok(followed) = follower.record(record) {
                    *record = followed;
                }
            }
            settings.horizon = Horizon::FreeRun;
            settings.report_horizons = vec![Horizon::FreeRun];
            follower
        }
        None => &model,
    };
    let settings = &settings;
    let u: Vec<f64> = (0..train.len()).flat_map(|k| logs[0].u(k).to_vec()).collect();
    let scales = nominal.scales(train.ts(), &u, train.len())?;
    let suspects = EverySite::new(library(), &model, scales);
    let candidates = suspects.alone().iter().flatten().count();
    let case = diagnose::Case { nominal, suspects: &suspects, logs: &logs, held_out: &held_out };
    let diagnosis = diagnose(&case, settings, &())?;
    let road = road(&case, &diagnosis, settings, MOST, &())?;
    let seconds = begun.elapsed().as_secs_f64();

    let above = diagnosis.best.gap.iter().zip(&diagnosis.floor).map(|(gap, f)| (gap / f).ln());
    let physical = |gaps: &[f64]| -> Vec<f64> {
        gaps.iter().zip(&diagnosis.sigma).map(|(gap, sigma)| gap * sigma).collect()
    };
    let together = match (&road, diagnosis.verdict, diagnosis.pairs.first()) {
        (Some(road), ..) if 1 < road.causes.len() => {
            road.causes.iter().map(|milestone| named(&milestone.cause)).collect()
        }
        (_, Verdict::Pair, Some(pair)) => pair.causes.iter().map(named).collect(),
        _ => Vec::new(),
    };
    let refit = diagnosis.refit.nuisances.iter().map(|n| (n.name.clone(), n.value));
    let closed = diagnosis.held_out.first().and_then(|held_out| held_out.closed_of_refit);
    Ok(Answer {
        case: name.to_owned(),
        error: None,
        verdict: verdict(diagnosis.verdict).to_owned(),
        no_gap: diagnosis.no_gap,
        // Its probability; what is left above the floor breaks ties.
        none_score: diagnosis.none_of_these + TIE_BREAK * above.fold(0.0, f64::max),
        says_none: diagnosis.verdict == Verdict::NoneOfThese,
        causes: diagnosis.causes.iter().take(KEPT).map(named).collect(),
        tied: diagnosis.tied.iter().map(|id| id.0).collect(),
        together,
        pairs: diagnosis.pairs.iter().take(KEPT).map(together_with).collect(),
        gaps: [&diagnosis.refit.gap, &diagnosis.best.gap, &diagnosis.floor]
            .map(|gaps| physical(gaps)),
        sigma: diagnosis.sigma.clone(),
        reading: Vec::new(),
        closed: closed.map(|c| Share { fraction: c.fraction, interval: c.interval }),
        refit: refit.collect(),
        patched: Some(diagnosis.best.model.to_string()),
        seconds,
        candidates,
        baselines: None,
    })
}

fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NoGap => "no gap",
        Verdict::Cause => "cause",
        Verdict::Tied => "tied",
        Verdict::Pair => "pair",
        Verdict::NoneOfThese => "none of these",
        Verdict::Unclear => UNCLEAR,
    }
}

fn together_with(pair: &Pair) -> Together {
    Together { causes: pair.causes.each_ref().map(named), probability: pair.probability }
}

fn named(cause: &Cause) -> Named {
    let side = match cause.side {
        Side::Input => "input",
        Side::Dynamics => "dynamics",
        Side::Output => "output",
    };
    Named {
        label: cause.label.to_owned(),
        law: cause.law.to_owned(),
        family: cause.family.to_owned(),
        side: side.to_owned(),
        site: cause.site.name().unwrap_or_default().to_owned(),
        partner: cause.partner.as_ref().and_then(|p| p.name()).map(str::to_owned),
        probability: cause.probability,
    }
}
