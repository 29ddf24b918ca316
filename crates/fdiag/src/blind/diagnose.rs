//! The one place where the blind test calls the diagnosis.

use std::time::Instant;

use fd_gap::{
    diagnose::{Cause, Diagnosis, Settings, diagnose},
    effect::{Candidate, ReplayScales, Side, library, offers, with_default_sites},
    model::{Draft, Model},
};
use fd_model::Record;

use super::{
    answer::{Answer, Named, Share},
    error::BlindError,
};

/// Causes that are kept in an answer.
const KEPT: usize = 20;

/// Diagnoses a case as a user would.
pub(super) fn answer(
    case: &str,
    model: &Model,
    train: &Record,
    held_out: &Record,
) -> Result<Answer, BlindError> {
    let begun = Instant::now();
    let model = with_default_sites(model);
    let u: Vec<f64> = (0..train.len()).flat_map(|k| train.u(k).to_vec()).collect();
    let scales = ReplayScales::of(&model, train.ts(), &u, train.len())?;
    let candidates: Vec<Candidate> =
        offers(&library(), &model, &scales).into_iter().flatten().collect();
    let (logs, held_out) = (std::slice::from_ref(train), std::slice::from_ref(held_out));
    let diagnosis = diagnose(&model, &candidates, logs, held_out, &Settings::default())?;
    let seconds = begun.elapsed().as_secs_f64();

    let ratio = |gap: &[f64]| {
        let pairs = gap.iter().zip(&diagnosis.floor);
        pairs.map(|(gap, floor)| (gap / floor).ln()).fold(0.0, f64::max)
    };
    let has_gap = diagnosis.no_gap < 0.5;
    let after = if has_gap { &diagnosis.best_gap } else { &diagnosis.refit_gap };
    let physical = |gaps: &[f64]| -> Vec<f64> {
        gaps.iter().zip(&diagnosis.sigma).map(|(gap, sigma)| gap * sigma).collect()
    };
    let closed = diagnosis.held_out.first().and_then(|held_out| held_out.closed_of_refit);
    Ok(Answer {
        case: case.to_owned(),
        error: None,
        no_gap: diagnosis.no_gap,
        none_score: ratio(after),
        says_none: diagnosis.is_unexplained,
        causes: diagnosis.causes.iter().take(KEPT).map(named).collect(),
        tied: diagnosis.tied.clone(),
        together: Vec::new(),
        gaps: [&diagnosis.refit_gap, after, &diagnosis.floor].map(|gaps| physical(gaps)),
        sigma: diagnosis.sigma.clone(),
        closed: closed.map(|c| Share { fraction: c.fraction, interval: c.interval }),
        refit: Vec::new(),
        patched: patched(&diagnosis, &candidates).map(|model| model.to_string()),
        seconds,
        candidates: candidates.len() - diagnosis.not_tested.len(),
        baselines: None,
    })
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

/// The model with the first cause in it, and all parameters as they were fitted.
fn patched(diagnosis: &Diagnosis, candidates: &[Candidate]) -> Option<Model> {
    let cause = diagnosis.causes.first()?;
    let mut draft: Draft = candidates.get(cause.candidate)?.model.clone().into_draft();
    let effect = cause.parameters.iter().map(|p| (&p.name, p.value));
    let nuisances = diagnosis.nuisances.iter().map(|(name, value, _)| (name, *value));
    for (name, value) in effect.chain(nuisances) {
        if let Some(parameter) = draft.parameters.iter_mut().find(|p| p.name == *name) {
            parameter.value = value;
        }
    }
    Model::try_from(draft).ok()
}
