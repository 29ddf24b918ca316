//! Objections to an answer, whatever its probability: what an engineer would object to at first sight.
//!
//! An objection that [forbids](Objection::forbids) an answer takes its name away: half of what was believed of it
//! is doubt then, and the verdict is [`Verdict::Unclear`]. The others are said beside it.

use fd_effect::SiteRef;

use super::held_out::Noise;
use crate::{
    diagnose::{
        judge::Probabilities,
        objection::Objection,
        result::{Cause, HeldOut, Pair, Verdict},
        sets::is_there,
        weigh::answer::Answer,
    },
    fit::{Log, Variable},
    quality::AT_THE_NOISE,
};

/// Strengths below so many standard errors are worth a word.
pub(crate) const FAINT: f64 = 2.0;
/// A forecast that is worse than another one by less than this factor is not worse.
const WORSE: f64 = 1.02;
/// Distance from the edge of a box, in its width, that counts as at the edge.
const EDGE: f64 = 1e-3;
/// Fewest parameters at their edges, and share of all, with which a model is not the one that was meant.
const MANY: usize = 3;
const MOST: f64 = 0.75;
/// By how much a log may read beyond what a saturated sensor can show, in its range.
const BEYOND: f64 = 0.1;
/// The same in standard deviations of the noise.
const NOISE: f64 = 6.0;

/// What an answer is held against.
#[derive(Clone, Copy, Debug)]
pub(super) struct Claim<'a> {
    /// The causes that the verdict names.
    pub causes: &'a [&'a Cause],
    /// Whether the only one of them follows anything.
    pub follows: bool,
    /// The best answer.
    pub answer: &'a Answer,
    /// Gaps on held-out logs.
    pub held_out: &'a [HeldOut],
    /// What is known of the noise.
    pub noise: Noise<'a>,
    /// The logs of the fit.
    pub logs: &'a [Log],
}

/// What speaks against the named causes, those that forbid them first; where none of the causes explains the gap, what speaks
/// against the model itself: that most of its parameters had to leave what is known of them.
pub(super) fn objections(claim: Claim<'_>, verdict: Verdict) -> Vec<Objection> {
    if verdict == Verdict::NoneOfThese {
        return at_edges(claim).into_iter().filter(Objection::forbids).collect();
    }
    if claim.causes.is_empty() {
        return Vec::new();
    }
    let mut all: Vec<Objection> =
        claim.causes.iter().filter_map(|cause| faint(cause, claim.held_out)).collect();
    all.extend(useless(claim));
    all.extend(not_shown(claim));
    all.extend(at_edges(claim));
    all.extend(claim.causes.iter().filter_map(|cause| beyond(cause, claim)));
    all.sort_by_key(|objection| !objection.forbids());
    all
}

/// Half of what was believed of causes and pairs is doubt.
pub(super) fn doubt(others: &mut Probabilities, causes: &mut [Cause], pairs: &mut [Pair]) {
    let left = 1.0 - others.no_gap;
    let of_causes = causes.iter_mut().map(|cause| &mut cause.probability);
    let mut named: Vec<&mut f64> =
        of_causes.chain(pairs.iter_mut().map(|pair| &mut pair.probability)).collect();
    let sum: f64 = named.iter().map(|p| **p).sum();
    others.none_of_these = others.none_of_these.max(0.5 * left);
    let factor = (left - others.none_of_these) / sum.max(f64::MIN_POSITIVE);
    for p in &mut named {
        **p *= factor.min(1.0);
    }
}

/// Whether held-out logs surely show what was added.
fn is_shown(held_out: &HeldOut) -> bool {
    held_out.closed_of_refit.is_some_and(|closed| 0.0 < closed.interval[0])
}

/// Whether they do at any horizon.
fn is_shown_at_all(held_out: &[HeldOut]) -> bool {
    held_out.iter().any(is_shown)
}

/// All strengths of a cause are within their errors. One that held-out logs clearly show is there all the same: it only
/// cannot be told from its other parameters.
fn faint(cause: &Cause, held_out: &[HeldOut]) -> Option<Objection> {
    if is_shown_at_all(held_out) {
        return None;
    }
    let largest = cause.significance()?;
    (largest < FAINT).then(|| Objection::FaintStrength {
        cause: cause.label.to_owned(),
        errors: largest,
        is_none: !is_there(cause),
    })
}

/// The explained model forecasts no better than something that needs no cause, at every horizon.
fn useless(claim: Claim<'_>) -> Vec<Objection> {
    let Claim { held_out, noise, answer, .. } = claim;
    // What explains the fitted logs down to the noise, and surely something of the held-out ones, is no artefact of a
    // model that stands still: the rest is where a held-out log begins, or what only that one shows.
    let gaps = answer.explanation.gap.iter().zip(noise.floors);
    let is_explained = gaps.into_iter().all(|(gap, floor)| *gap < AT_THE_NOISE * floor);
    if is_explained && !held_out.is_empty() && held_out.iter().all(is_shown) {
        return Vec::new();
    }
    let loses = |rival: fn(&HeldOut) -> &Vec<f64>| {
        !held_out.is_empty()
            && held_out.iter().all(|h| {
                let after = h.total(|h| &h.after, noise.sigma);
                let floor = h.total(|h| &h.floor, noise.sigma);
                WORSE * h.total(rival, noise.sigma) < after && AT_THE_NOISE * floor < after
            })
    };
    let mut all = Vec::new();
    if loses(|h| &h.constant) {
        all.push(Objection::NoBetterThanConstant);
    }
    if loses(|h| &h.last_value) {
        all.push(Objection::NoBetterThanLastValue);
    }
    if loses(|h| &h.nominal) {
        all.push(Objection::WorseThanNominal);
    }
    // Of a gap that is hardly above the noise, shares say more than sizes.
    let is_harm = |h: &HeldOut| h.closed_of_refit.is_some_and(|closed| closed.fraction < 0.0);
    if !held_out.is_empty() && held_out.iter().all(is_harm) {
        all.push(Objection::WorseThanRefitted);
    }
    all
}

/// A curve or a path that no held-out log shows.
fn not_shown(claim: Claim<'_>) -> Option<Objection> {
    let Claim { follows, held_out, .. } = claim;
    let is_tested = held_out.iter().any(|h| h.closed_of_refit.is_some());
    (follows && is_tested && !is_shown_at_all(held_out)).then_some(Objection::NotShown)
}

/// Refitted parameters at the edges of what their tolerances allow. Where small effects that nobody listed push most of them
/// there, a cause that held-out logs clearly show is there all the same.
fn at_edges(claim: Claim<'_>) -> Option<Objection> {
    let Claim { answer, held_out, .. } = claim;
    let fit = answer.fit.as_ref()?;
    let nuisances = fit.problem.plan().nuisances();
    let is_at_edge = |(variable, z): (&Variable, &f64)| {
        let [low, high] = variable.range();
        let near = EDGE * (high - low);
        (*z - low < near || high - z < near).then(|| variable.name.clone())
    };
    let names: Vec<String> = nuisances.iter().zip(&fit.minimum.z).filter_map(is_at_edge).collect();
    let is_most = MANY <= names.len() && MOST * nuisances.len() as f64 <= names.len() as f64;
    (!names.is_empty()).then_some(Objection::ParametersAtEdges {
        names,
        of: nuisances.len(),
        is_most,
        is_shown: !claim.causes.is_empty() && is_shown_at_all(held_out),
    })
}

/// The log reads what a saturated sensor could not show.
fn beyond(cause: &Cause, claim: Claim<'_>) -> Option<Objection> {
    let SiteRef::Output(c, _) = &cause.site else { return None };
    if cause.label != "sensor-saturation" {
        return None;
    }
    let ends = |values: &mut dyn Iterator<Item = f64>| {
        values
            .filter(|v| v.is_finite())
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
    };
    let width = claim.logs.first()?.ny;
    let shown = claim.answer.explanation.outputs.iter();
    let shown = ends(&mut shown.flat_map(|rows| rows.iter().skip(*c).step_by(width)).copied());
    let logs = claim.logs.iter();
    let read = ends(&mut logs.flat_map(|log| log.y.iter().skip(*c).step_by(log.ny)).copied());
    let least = (BEYOND * (shown[1] - shown[0])).max(NOISE * claim.noise.sigma[*c]);
    let beyond = [(shown[0] - read[0], 0), (read[1] - shown[1], 1)];
    let (_, end) =
        beyond.into_iter().filter(|(by, _)| least < *by).max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Objection::ReadsBeyondLimit { limit: shown[end], reads: read[end] })
}
