//! One answer next to its truth.

use std::ops::Range;

use fd_effect::Candidate;
use fd_gap::{
    fit::{Horizon, Log},
    shrink::{Settled, forecast_errors, gap},
};
use fd_sim::{
    model::Model,
    simulate::{EquationSimulator, Simulator},
};
use serde::{Deserialize, Serialize};

use crate::blind::{
    answer::{Answer, Named},
    error::BlindError,
    laws::Place,
    oracle::{SEPARATED, distance_of},
    run::Case,
    truth::{CaseKind, Effect, Scene, Truth},
};

/// Runs that no diagnosis has seen, from which the real share of the gap that is closed follows.
const FRESH: Range<u64> = 2..6;
/// A gap that is less than this above the noise cannot be shared out.
const REDUCIBLE: f64 = 0.02;
/// Noise floor reached: so much above the real noise.
const REACHED: f64 = 1.1;

/// One answer next to its truth.
#[allow(clippy::struct_excessive_bools, reason = "each is a question of its own")]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Name of the case.
    pub case: String,
    /// Kind.
    pub kind: String,
    /// Plant.
    pub plant: String,
    /// Whether the noise is coloured.
    pub coloured: bool,
    /// What was put in: label, law, site.
    pub truth: Vec<String>,
    /// Mechanism of the first effect, or `no gap`.
    pub truth_family: String,
    /// What was said first: label, law, site.
    pub said: String,
    /// Its mechanism, or `no gap`.
    pub said_family: String,
    /// Squares of the noise that the best fit without any effect leaves of the truth, see
    /// [`Oracle::nothing`](crate::blind::Oracle::nothing).
    pub distance: f64,
    /// Whether the effect leaves a trace at all.
    pub is_visible: bool,
    /// Whether some other single effect of the library leaves less than 9 squares of the noise.
    pub is_mimicked: bool,
    /// What the nearest single effect of the library leaves, where that was looked for.
    pub nearest: Option<f64>,
    /// Label and site are right.
    pub is_exact: bool,
    /// Right, or not to be told from the truth by this log.
    pub is_right: bool,
    /// Mechanism and site are right, or not to be told from the truth.
    pub is_group_right: bool,
    /// The side of the plant is right, or not to be told from the truth.
    pub is_side_right: bool,
    /// Probability of the first cause and those that the diagnosis cannot tell from it.
    pub probability: f64,
    /// Probability of their mechanism at their site.
    pub group_probability: f64,
    /// Probability that there is a gap.
    pub blamed: f64,
    /// How much speaks for none of the known causes.
    pub none_score: f64,
    /// Whether the diagnosis says "none of these".
    pub says_none: bool,
    /// Whether a single cause was named, without an alternative.
    pub is_alone: bool,
    /// Two effects: both are named, and nothing else.
    pub is_pair_exact: bool,
    /// Two effects: as above, or what is named cannot be told from them.
    pub is_pair_right: bool,
    /// Two effects: at least one is named.
    pub is_half_exact: bool,
    /// Whether the training residual came down to the real noise.
    pub is_floor_reached: bool,
    /// Stated share of the gap that is closed.
    pub closed: Option<f64>,
    /// The real share, from runs that nobody has seen.
    pub really_closed: Option<f64>,
    /// Whether the stated interval contains the real share.
    pub is_covered: Option<bool>,
    /// Time of the diagnosis, in seconds.
    pub seconds: f64,
    /// Names by the refit and by the sparse regression are right.
    pub baseline_right: [bool; 2],
    /// Shares that refit, black box and sparse regression close.
    pub baseline_closed: [Option<f64>; 3],
    /// Why there is no diagnosis.
    pub error: Option<String>,
}

/// Mechanisms that a catch-all map at a site stands for.
fn families_of_map(named: &Named) -> &'static [&'static str] {
    match (named.label.as_str(), named.law.as_str()) {
        ("input-map", "of-input") => &["actuator-gain", "actuator-offset", "actuator-nonlinearity"],
        ("input-map", "of-time") => &["actuator-offset"],
        ("force-map", "of-velocity") => &["friction"],
        ("force-map", "of-position") => &["stiffness", "load", "limit"],
        ("force-map", "of-time") => &["load"],
        ("sensor-map", "of-output") => &["sensor-gain", "sensor-offset", "sensor-nonlinearity"],
        ("sensor-map", "of-time") => &["sensor-offset"],
        _ => &[],
    }
}

/// Whether two causes are of one group: mechanism and place.
fn is_one_group(first: &Named, other: &Named) -> bool {
    let (a, b) = (families_of_map(first), families_of_map(other));
    let is_one_mechanism = first.family == other.family
        || a.contains(&other.family.as_str())
        || b.contains(&first.family.as_str());
    first.site == other.site && is_one_mechanism
}

pub(super) fn is_exact(effect: &Effect, label: &str, site: &str, partner: Option<&str>) -> bool {
    let is_partner = match (effect.partner.as_deref(), partner) {
        (Some(a), Some(b)) => a == b,
        _ => true,
    };
    effect.label == label && effect.site == site && is_partner
}

fn is_group(effect: &Effect, named: &Named) -> bool {
    let map = families_of_map(named);
    let is_mechanism = effect.family == named.family || map.contains(&effect.family.as_str());
    effect.site == named.site && is_mechanism
}

fn side(effect: &Effect) -> &'static str {
    match effect.place {
        Place::Input => "input",
        Place::Force | Place::Parameter => "dynamics",
        Place::Output => "output",
    }
}

/// Judges an answer. `refits` says whether to look, by refits to the noise-free truth, if an answer
/// that is not exact is one that no log could tell from the truth, and what share is really closed.
pub(super) fn judge(
    case: Option<&Case>,
    truth: &Truth,
    answer: &Answer,
) -> Result<Verdict, BlindError> {
    let oracle = truth.oracle.clone().unwrap_or_default();
    let is_measurement = |effect: &Effect| {
        ["sensor-noise", "sensor-outliers", "sensor-quantisation"].contains(&effect.label.as_str())
    };
    let corrupts = truth.effects.iter().any(is_measurement);
    let distance = if corrupts {
        truth.effects.iter().map(|effect| effect.distance).fold(0.0, f64::max)
    } else {
        oracle.nothing
    };
    let first = answer.first();
    let words = |label: &str, law: &str, site: &str| format!("{label} ({law}) at {site}");
    let none = || "no gap".to_owned();
    let effect = truth.effects.first();
    let mut verdict = Verdict {
        case: truth.case.clone(),
        kind: truth.kind.name().to_owned(),
        plant: truth.plant.clone(),
        coloured: truth.coloured,
        truth: truth.effects.iter().map(|e| words(&e.label, &e.law, &e.site)).collect(),
        truth_family: effect.map_or_else(none, |e| e.family.clone()),
        said: first.map_or_else(none, |n| words(&n.label, &n.law, &n.site)),
        said_family: first.map_or_else(none, |n| n.family.clone()),
        distance,
        is_visible: SEPARATED <= distance,
        is_mimicked: !oracle.ties.is_empty(),
        nearest: oracle.best.as_ref().map(|best| best.distance),
        blamed: answer.blamed(),
        none_score: answer.none_score,
        says_none: answer.says_none,
        is_alone: first.is_some() && answer.verdict == "cause",
        closed: answer.closed.map(|share| share.fraction),
        seconds: answer.seconds,
        error: answer.error.clone(),
        ..Verdict::default()
    };
    if let Some(first) = first {
        // What the diagnosis cannot tell from its first cause is one answer with it, as it is here.
        let sum = |wanted: &dyn Fn(usize, &Named) -> bool| -> f64 {
            let causes = answer.causes.iter().enumerate();
            causes.filter(|(i, c)| *i == 0 || wanted(*i, c)).map(|(_, c)| c.probability).sum()
        };
        verdict.probability = sum(&|i, _| answer.tied.contains(&i));
        // A mechanism is at work alone, or as one of two.
        let with = answer.pairs.iter().filter(|p| p.causes.iter().any(|c| is_one_group(first, c)));
        verdict.group_probability =
            sum(&|i, cause| answer.tied.contains(&i) || is_one_group(first, cause))
                + with.map(|pair| pair.probability).sum::<f64>();
    }
    if let (Some(effect), Some(first)) = (effect, first) {
        verdict.is_exact = is_exact(effect, &first.label, &first.site, first.partner.as_deref());
        verdict.is_side_right = side(effect) == first.side;
        verdict.is_group_right = verdict.is_exact || is_group(effect, first);
        let is_tie =
            |r: &&crate::blind::oracle::Rival| r.label == first.label && r.site == first.site;
        let mut is_right = verdict.is_exact || oracle.ties.iter().any(|rival| is_tie(&rival));
        let is_single = matches!(truth.kind, CaseKind::Single | CaseKind::Mismatch);
        if let (Some(case), false, true, true) =
            (case, is_right, is_single, verdict.is_visible && !corrupts)
        {
            is_right = left(case, truth, &[first])? < SEPARATED;
        }
        verdict.is_right = is_right;
        verdict.is_group_right |= is_right;
        verdict.is_side_right |= is_right;
    }
    if truth.kind == CaseKind::Pair {
        let said: Vec<&Named> = if answer.together.is_empty() {
            first.into_iter().collect()
        } else {
            answer.together.iter().collect()
        };
        let is_said = |effect: &&Effect| {
            said.iter().any(|n| is_exact(effect, &n.label, &n.site, n.partner.as_deref()))
        };
        let found = truth.effects.iter().filter(|effect| is_said(effect)).count();
        verdict.is_pair_exact = found == 2 && said.len() == 2;
        verdict.is_half_exact = 0 < found;
        verdict.is_pair_right = verdict.is_pair_exact
            || match case {
                Some(case) if verdict.is_visible && !said.is_empty() && !corrupts => {
                    left(case, truth, &said)? < SEPARATED
                }
                _ => false,
            };
    }
    for (i, baseline) in answer.baselines.iter().flat_map(|b| [&b.refit, &b.sparse]).enumerate() {
        let right = |(label, site): &(String, String)| {
            effect.is_some_and(|effect| is_exact(effect, label, site, None))
        };
        verdict.baseline_right[i] = baseline.named.as_ref().is_some_and(right);
    }
    if let Some(b) = &answer.baselines {
        verdict.baseline_closed = [b.refit.closed, b.black_box.closed, b.sparse.closed];
    }
    if let Some(case) = case {
        look_closer(case, truth, answer, &mut verdict)?;
    }
    Ok(verdict)
}

/// What the named causes, in any of their laws, leave of the noise-free truth.
fn left(case: &Case, truth: &Truth, named: &[&Named]) -> Result<f64, BlindError> {
    let model = case.model()?;
    let scene = Scene::new(truth, &model)?;
    let Some(clean) = scene.log(0, false)? else { return Ok(f64::INFINITY) };
    let wanted: Vec<_> = named
        .iter()
        .map(|named| {
            move |candidate: &Candidate| {
                let partner = candidate.partner.as_ref().and_then(|p| p.name());
                candidate.label == named.label
                    && candidate.site.name() == Some(&named.site)
                    && partner == named.partner.as_deref()
            }
        })
        .collect();
    let wanted: Vec<&dyn Fn(&Candidate) -> bool> = wanted.iter().map(|w| w as _).collect();
    distance_of(&scene, &clean, &wanted)
}

/// The real noise, and the share that is really closed.
fn look_closer(
    case: &Case,
    truth: &Truth,
    answer: &Answer,
    verdict: &mut Verdict,
) -> Result<(), BlindError> {
    let model = case.model()?;
    let scene = Scene::new(truth, &model)?;
    let Some(noise) = noise(&scene, 0..1)? else { return Ok(()) };
    verdict.is_floor_reached = answer.gaps[1].len() == noise.len()
        && answer.gaps[1].iter().zip(&noise).all(|(gap, noise)| *gap <= REACHED * noise);
    let (Some(stated), Some(patched)) = (answer.closed, &answer.patched) else { return Ok(()) };
    if answer.sigma.len() != noise.len() || !verdict.is_visible {
        return Ok(());
    }
    let Ok(patched) = patched.parse::<Model>() else { return Ok(()) };
    verdict.really_closed = really_closed(&scene, &patched, answer)?;
    verdict.is_covered =
        verdict.really_closed.map(|real| stated.interval[0] <= real && real <= stated.interval[1]);
    Ok(())
}

/// Root mean square of what noise does to each output in some runs, around the loop as well; `None`
/// when the plant diverges.
fn noise(scene: &Scene<'_>, runs: Range<u64>) -> Result<Option<Vec<f64>>, BlindError> {
    let mut squares = vec![0.0; scene.model.outputs.len()];
    let mut samples = 0.0;
    for run in runs {
        let (Some(noisy), Some(clean)) = (scene.log(run, true)?, scene.log(run, false)?) else {
            return Ok(None);
        };
        for k in 0..noisy.len() {
            for (square, (noisy, clean)) in
                squares.iter_mut().zip(noisy.y(k).iter().zip(clean.y(k)))
            {
                *square += (noisy - clean).powi(2);
            }
            samples += 1.0;
        }
    }
    Ok(Some(squares.into_iter().map(|square: f64| (square / samples).sqrt()).collect()))
}

fn really_closed(
    scene: &Scene<'_>,
    patched: &Model,
    answer: &Answer,
) -> Result<Option<f64>, BlindError> {
    let Some(noise) = noise(scene, FRESH)? else { return Ok(None) };
    let nominal = EquationSimulator::<f64>::new(scene.model)?;
    let with = EquationSimulator::<f64>::at(patched, nominal.ts())?;
    let mut logs = Vec::new();
    for run in FRESH {
        if let Some(record) = scene.log(run, true)? {
            logs.push(Log::new(&record, &nominal, logs.len() + 1)?);
        }
    }
    let values: Vec<(String, f64)> =
        patched.parameters.iter().map(|p| (p.name.clone(), p.value)).collect();
    let error = |simulator: &dyn Simulator, nuisances: &[(String, f64)]| {
        let settled = Settled { simulator, nuisances, effects: &[] };
        forecast_errors(&nominal, settled, &logs, Horizon::FreeRun, &answer.sigma)
    };
    let before = error(&nominal, &answer.refit)?;
    let after = error(&with, &values)?;
    let (Some(before), Some(after)) = (before, after) else { return Ok(None) };
    let squares = noise.iter().zip(&answer.sigma).map(|(noise, sigma)| (noise / sigma).powi(2));
    let floor = (squares.sum::<f64>() / noise.len() as f64).sqrt();
    let (before, after) = (gap(&before) - floor, gap(&after) - floor);
    Ok((REDUCIBLE * floor < before).then(|| 1.0 - after / before))
}
