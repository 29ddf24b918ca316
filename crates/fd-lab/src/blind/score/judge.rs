//! One answer next to its truth.

mod cause;
mod closer;
mod list;
mod said;
mod verdict;

pub use self::verdict::{OfSeveral, Verdict};
use self::{
    cause::{is_exact, left, sought},
    list::judge_list,
    said::mechanism_of,
};
use crate::blind::{
    answer::{Answer, Named, Reading},
    error::BlindError,
    files::{Case, Variant},
    kind::CaseKind,
    laws::Place,
    logger::Logger,
    misreading::Misreading,
    oracle::SEPARATED,
    truth::{Effect, Truth},
};

/// Relative error of a factor or a shift that counts as none.
const NEAR: f64 = 0.2;

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

fn is_group(effect: &Effect, named: &Named) -> bool {
    let map = families_of_map(named);
    let mechanism = mechanism_of(effect);
    let is_mechanism = mechanism == named.family || map.contains(&mechanism);
    effect.site == named.site && is_mechanism
}

fn side(effect: &Effect) -> &'static str {
    match effect.place {
        Place::Input => "input",
        Place::Force | Place::Parameter | Place::Inside => "dynamics",
        Place::Output => "output",
    }
}

/// Judges an answer. With a case it looks, by refits to the noise-free truth, if an answer that is
/// not exact is one that no log could tell from the truth, and what share is really closed.
pub(super) fn judge(
    case: Option<(&Case, Variant)>,
    truth: &Truth,
    answer: &Answer,
) -> Result<Verdict, BlindError> {
    let answer = &answer.with_steps_named(truth);
    let (variant, case) = (case.map_or(Variant::AsLogged, |(_, v)| v), case.map(|(case, _)| case));
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
    // What the logger does is in the log, too; who names it has not named the effect by that.
    let is_logger = |named: &&Named| {
        let logger = truth.conditions.logger.as_ref();
        logger.is_some_and(|logger| of_logger(logger, case, named))
    };
    let said_first = answer.first();
    let is_first_of_logger = said_first.as_ref().is_some_and(is_logger);
    let first = said_first.filter(|_| !is_first_of_logger).or_else(|| {
        let others = answer.together.iter().find(|named| !is_logger(named));
        others.filter(|_| is_first_of_logger)
    });
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
        blamed: if first.is_none() && is_first_of_logger { 0.0 } else { answer.blamed() },
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
    if let Some(first) = first {
        judge_first(case, truth, first, corrupts, &mut verdict)?;
    }
    if 1 < truth.kind.effects() {
        judge_list(case, truth, answer, first, corrupts, &mut verdict)?;
    }
    if let Some(misreading) = &truth.conditions.misreading {
        judge_reading(misreading, answer, &mut verdict);
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
    let is_comparable = variant != Variant::KnownController && truth.kind != CaseKind::Misread;
    if let Some(case) = case.filter(|_| is_comparable) {
        closer::look(case, truth, answer, &mut verdict)?;
    }
    Ok(verdict)
}

/// Whether the first cause is the first effect, or one that no log could tell from it.
fn judge_first(
    case: Option<&Case>,
    truth: &Truth,
    first: &Named,
    corrupts: bool,
    verdict: &mut Verdict,
) -> Result<(), BlindError> {
    let oracle = truth.oracle.clone().unwrap_or_default();
    if let Some(effect) = truth.effects.first() {
        verdict.is_exact = is_exact(effect, &first.label, &first.site, first.partner.as_deref());
        verdict.is_side_right = side(effect) == first.side;
        verdict.is_group_right = verdict.is_exact || is_group(effect, first);
        let is_tie =
            |r: &&crate::blind::rival::Rival| r.label == first.label && r.site == first.site;
        let mut is_right = verdict.is_exact || oracle.ties.iter().any(|rival| is_tie(&rival));
        let is_single = truth.kind.has_one_effect();
        if let (Some(case), false, true, true) =
            (case, is_right, is_single, verdict.is_visible && !corrupts)
        {
            is_right = left(case, truth, [sought(first)])? < SEPARATED;
        }
        verdict.is_right = is_right;
        verdict.is_group_right |= is_right;
        verdict.is_side_right |= is_right;
    }
    Ok(())
}

/// Whether a mistake of reading is told, or taken for physics.
fn judge_reading(misreading: &Misreading, answer: &Answer, verdict: &mut Verdict) {
    let told = answer.reading.first().filter(|told| 0.5 < told.probability);
    // What no log can tell apart is told when either is: the clocks of the only two channels, say.
    let tied = answer.reading.iter().skip(1).filter(|reading| reading.is_tied);
    verdict.is_reading_told = told
        .into_iter()
        .chain(tied.filter(|_| told.is_some()))
        .any(|told| is_told(misreading, told));
    verdict.is_taken_for_physics =
        told.is_none() && 0.5 < verdict.blamed && 0.5 < verdict.probability && !answer.says_none;
    verdict.is_right = verdict.is_reading_told;
}

/// Whether a cause is what the logger does to an output.
fn of_logger(logger: &Logger, case: Option<&Case>, named: &Named) -> bool {
    let model = case.and_then(|case| case.model().ok());
    let outputs = model.map(|model| model.outputs.clone()).unwrap_or_default();
    let place = outputs.iter().position(|output| output.name == named.site);
    place.is_some_and(|c| logger.labels(c).contains(&named.label.as_str()))
}

/// Whether a reading is the mistake: kind, channels, and the factor or the shift to within a fifth.
fn is_told(misreading: &Misreading, told: &Reading) -> bool {
    let sorted = |names: &mut dyn Iterator<Item = &str>| {
        let mut names: Vec<String> = names.map(str::to_owned).collect();
        names.sort_unstable();
        names
    };
    let channels = sorted(&mut told.channels.iter().map(String::as_str));
    let is_near = |told: Option<f64>, real: f64| {
        told.is_some_and(|told| (told - real).abs() <= NEAR * real.abs())
    };
    let is_size = match misreading {
        Misreading::Unit { factor, .. } => is_near(told.factor, *factor),
        Misreading::Time { factor } => is_near(told.factor, 1.0 / *factor as f64),
        Misreading::Clock { late, .. } => is_near(told.late, *late as f64),
        Misreading::Sign { .. } | Misreading::Swap { .. } => true,
    };
    told.kind == misreading.name()
        && channels == sorted(&mut misreading.channels().into_iter())
        && is_size
}
