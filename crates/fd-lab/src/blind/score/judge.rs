//! One answer next to its truth.

mod closer;
mod list;
mod said;

use fd_effect::Candidate;
use serde::{Deserialize, Serialize};

pub use self::list::OfSeveral;
use self::{
    list::judge_list,
    said::{mechanism_of, said_of},
};
use crate::blind::{
    answer::{Answer, Named, Reading},
    error::BlindError,
    files::{Case, Variant},
    kind::CaseKind,
    laws::Place,
    logger::Logger,
    misreading::Misreading,
    oracle::{SEPARATED, distance_of},
    truth::{Effect, Scene, Truth},
};

/// Relative error of a factor or a shift that counts as none.
const NEAR: f64 = 0.2;

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
    /// A list of effects: the largest is named first, or what no log could tell from it.
    pub is_dominant_first: bool,
    /// A list of effects: all are named and nothing else, or the list leaves nothing.
    pub is_list_right: bool,
    /// Several effects: what the log holds of each, and whether it is named.
    #[serde(default)]
    pub of_several: Vec<OfSeveral>,
    /// Several effects: how many of the named causes are among them, label and site, of how many.
    #[serde(default)]
    pub named_of_several: [usize; 2],
    /// A mistake of reading is told as what it is.
    pub is_reading_told: bool,
    /// It is taken for physics: a cause in the plant is stated with a probability above one half.
    pub is_taken_for_physics: bool,
    /// Why there is no diagnosis.
    pub error: Option<String>,
}

impl Verdict {
    /// Whether it is of the first kinds of cases.
    pub(super) fn is_plain(&self) -> bool {
        CaseKind::ALL.iter().any(|kind| kind.is_plain() && kind.name() == self.kind)
    }
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
    said_of(effect) == label && effect.site == site && is_partner
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
            |r: &&crate::blind::oracle::Rival| r.label == first.label && r.site == first.site;
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

/// Label, site and partner of a cause.
type Sought<'a> = (&'a str, &'a str, Option<&'a str>);

fn sought(named: &Named) -> Sought<'_> {
    (&named.label, &named.site, named.partner.as_deref())
}

/// What causes, in any of their laws, leave of the noise-free truth.
fn left<'a>(
    case: &Case,
    truth: &Truth,
    causes: impl IntoIterator<Item = Sought<'a>>,
) -> Result<f64, BlindError> {
    let model = case.model()?;
    let scene = Scene::new(truth, &model)?;
    let wanted = causes.into_iter().map(|(label, site, partner)| {
        move |candidate: &Candidate| {
            candidate.label == label
                && candidate.site.name() == Some(site)
                && candidate.partner.as_ref().and_then(|p| p.name()) == partner
        }
    });
    let wanted: Vec<_> = wanted.collect();
    let wanted: Vec<&dyn Fn(&Candidate) -> bool> = wanted.iter().map(|w| w as _).collect();
    distance_of(&scene, &wanted)
}
