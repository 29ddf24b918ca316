//! Scores of logs as people have them, class by class.

use fd_numeric::{median, quantile};
use serde::{Deserialize, Serialize};

use super::{
    judge::Verdict,
    statistics::{Calibration, Rate},
    threshold::{FALSE_ABSTENTION, SURE},
};
use crate::blind::kind::CaseKind;

/// Squares of the noise from which an effect beside others can be told from chance by one of a hundred candidates: twice
/// the logarithm of the odds against each, and as much again for its strengths.
const HELD: f64 = 25.0;

/// What is counted of a class.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ClassScore {
    /// Name of its kind.
    pub name: String,
    /// What it is.
    pub title: String,
    /// Cases with something wrong, and of these the ones where it can be seen.
    pub visible: Rate,
    /// The first cause is right, or not to be told from the truth.
    pub right: Rate,
    /// The first cause has the very label and site.
    pub exact: Rate,
    /// Mechanism and place.
    pub place: Rate,
    /// One cause named: it is right.
    pub alone: Rate,
    /// Stated with a probability above 0.9, alone or not, and right.
    pub sure: Rate,
    /// "None of these" said of what the library has.
    pub falsely_none: Rate,
    /// An unknown class told by the diagnosis itself, and where 3 % of the known ones are doubted.
    pub told: [Rate; 2],
    /// Nothing wrong, but blamed: white, coloured noise.
    pub blamed: [Rate; 2],
    /// The largest of several effects first; the list exact or inseparable; the same where the log holds each of them.
    pub list: [Rate; 3],
    /// Effects of several that the log holds, and of these the ones that are named; causes named, and of these the ones that
    /// are effects.
    pub of_several: [Rate; 2],
    /// Mistakes of reading told, and taken for physics.
    pub reading: [Rate; 2],
    /// Intervals of the closed share that contain the real one.
    pub coverage: Rate,
    /// Calibration of the probabilities of groups.
    pub group: Calibration,
    /// Diagnoses that failed.
    pub failed: Rate,
    /// Median and 90 % quantile of the time of a diagnosis, in seconds.
    pub seconds: [f64; 2],
    /// Named rightly by the refit and by the sparse regression.
    pub baselines: [Rate; 2],
    /// The same cases as they could have been: with the controller in the model, from rest.
    pub comparison: Option<Comparison>,
}

/// The same cases in another form.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// Which form.
    pub form: String,
    /// The first cause is right or not to be told from the truth: as logged, in this form.
    pub right: [Rate; 2],
    /// Stated with a probability above 0.9, and right, in this form.
    pub sure: Rate,
    /// Nothing wrong, but blamed, in this form.
    pub blamed: Rate,
}

/// The classes: kind, that of nothing wrong, what it is.
const CLASSES: [(CaseKind, Option<CaseKind>, &str); 9] = [
    (CaseKind::Loop, Some(CaseKind::LoopNone), "Loops with an unknown controller"),
    (CaseKind::Unstable, Some(CaseKind::UnstableNone), "Unstable plants, held by one"),
    (CaseKind::Cut, Some(CaseKind::CutNone), "One run cut in two"),
    (CaseKind::InMotion, Some(CaseKind::InMotionNone), "Logs that begin in motion"),
    (CaseKind::Dominant, None, "One large effect among three small ones"),
    (CaseKind::Coarse, Some(CaseKind::CoarseNone), "Coarse steps and short ranges"),
    (CaseKind::Patchy, Some(CaseKind::PatchyNone), "Jitter and holes"),
    (CaseKind::Misread, None, "Mistakes of reading"),
    (CaseKind::Wander, None, "Wandering parameters"),
];
const INSIDE: (CaseKind, Option<CaseKind>, &str) =
    (CaseKind::Inside, None, "Effects on signals inside the model");

/// All classes that have cases; `others` are the same cases with a known controller and from rest.
pub(super) fn all(verdicts: &[Verdict], others: &[Vec<Verdict>; 2]) -> Vec<ClassScore> {
    let classes = CLASSES.into_iter().chain([INSIDE]);
    let scores = classes.map(|(kind, null, title)| of_class(verdicts, others, kind, null, title));
    scores
        .filter(|score| {
            [score.visible, score.reading[0]].iter().any(|r| 0 < r.of)
                || score.blamed.iter().any(|b| 0 < b.of)
        })
        .collect()
}

fn of_class(
    verdicts: &[Verdict],
    others: &[Vec<Verdict>; 2],
    kind: CaseKind,
    null: Option<CaseKind>,
    title: &str,
) -> ClassScore {
    let of = |all: &'_ [Verdict], kind: CaseKind| -> Vec<Verdict> {
        all.iter().filter(|v| v.kind == kind.name()).cloned().collect()
    };
    let all = of(verdicts, kind);
    // A misreading is no effect of the plant, and is to be seen in every log.
    let seen: Vec<&Verdict> =
        all.iter().filter(|v| v.is_visible || kind == CaseKind::Misread).collect();
    let nulls = null.map(|null| of(verdicts, null)).unwrap_or_default();
    let coloured = |is: bool| nulls.iter().filter(|v| v.coloured == is).collect::<Vec<_>>();
    let alone: Vec<&Verdict> = seen.iter().copied().filter(|v| v.is_alone).collect();
    // Right or wrong to be named at all: where the library has no such thing, only "none of these"
    // or the very cause.
    let strange: Vec<&Verdict> = if is_unknown(kind) {
        seen.iter().copied().filter(|v| !v.is_mimicked).collect()
    } else {
        vec![]
    };
    let known: Vec<&Verdict> =
        if is_unknown(kind) || kind == CaseKind::Misread { vec![] } else { seen.clone() };
    let mut doubts: Vec<f64> = verdicts
        .iter()
        .filter(|v| v.kind == CaseKind::Single.name() && v.is_visible)
        .map(|v| v.none_score)
        .collect();
    let threshold = if doubts.is_empty() {
        f64::INFINITY
    } else {
        quantile(&mut doubts, 1.0 - FALSE_ABSTENTION)
    };
    let is_doubted = |v: &&Verdict| threshold < v.none_score;
    let told_by_score =
        if threshold.is_finite() { Rate::of(&strange, is_doubted) } else { Rate::new(0, 0) };
    let said = seen.iter().filter(|v| 0.5 < v.blamed);
    let pairs: Vec<(f64, bool)> = said.map(|v| (v.group_probability, v.is_group_right)).collect();
    let covered: Vec<bool> = seen.iter().filter_map(|v| v.is_covered).collect();
    let times = all.iter().chain(&nulls).map(|v| v.seconds);
    let times: Vec<f64> = times.collect();
    let only = |wanted: bool, rate: Rate| if wanted { rate } else { Rate::new(0, 0) };
    let is_misread = kind == CaseKind::Misread;
    let is_list = 1 < kind.effects();
    let is_held = |v: &&Verdict| {
        !v.of_several.is_empty() && v.of_several.iter().all(|effect| HELD <= effect.worth)
    };
    let told: Vec<&Verdict> = seen.iter().copied().filter(is_held).collect();
    ClassScore {
        name: kind.name().to_owned(),
        title: title.to_owned(),
        visible: only(!is_misread, Rate::of(&all, |v| v.is_visible)),
        right: only(!is_misread, Rate::of(&seen, |v| v.is_right)),
        exact: only(!is_misread, Rate::of(&seen, |v| v.is_exact)),
        place: only(!is_misread, Rate::of(&seen, |v| v.is_group_right)),
        alone: only(!is_misread, Rate::of(&alone, |v| v.is_right)),
        sure: sure(&seen),
        falsely_none: Rate::of(&known, |v| v.says_none),
        told: [Rate::of(&strange, |v| v.says_none), told_by_score],
        blamed: [false, true].map(|is| Rate::of(&coloured(is), |v| 0.5 < v.blamed)),
        list: [
            only(is_list, Rate::of(&seen, |v| v.is_dominant_first)),
            only(is_list, Rate::of(&seen, |v| v.is_list_right)),
            only(is_list, Rate::of(&told, |v| v.is_list_right)),
        ],
        of_several: of_several(&seen),
        reading: [
            only(is_misread, Rate::of(&seen, |v| v.is_reading_told)),
            only(is_misread, Rate::of(&seen, |v| v.is_taken_for_physics)),
        ],
        coverage: Rate::of(&covered, |covered| *covered),
        group: Calibration::of(&pairs),
        failed: Rate::of(&[all.clone(), nulls.clone()].concat(), |v| v.error.is_some()),
        seconds: [median(&mut times.clone()), quantile(&mut times.clone(), 0.9)],
        baselines: [0, 1].map(|i| only(!is_misread, Rate::of(&seen, |v| v.baseline_right[i]))),
        comparison: comparison(&all, others, kind, null),
    }
}

/// Of several effects, those that the log holds and that are named; of the named causes, those that are effects.
fn of_several(seen: &[&Verdict]) -> [Rate; 2] {
    let effects = seen.iter().flat_map(|v| &v.of_several).filter(|effect| HELD <= effect.worth);
    let [right, named] =
        seen.iter().map(|v| v.named_of_several).fold([0, 0], |[a, b], [c, d]| [a + c, b + d]);
    [Rate::of(&effects.collect::<Vec<_>>(), |effect| effect.is_named), Rate::new(right, named)]
}

/// Whether the library has no such class.
fn is_unknown(kind: CaseKind) -> bool {
    matches!(kind, CaseKind::Wander | CaseKind::Inside)
}

fn sure(seen: &[&Verdict]) -> Rate {
    let sure = seen.iter().filter(|v| SURE < v.probability && 0.5 < v.blamed && !v.says_none);
    Rate::of(&sure.collect::<Vec<_>>(), |v| v.is_right)
}

fn comparison(
    all: &[Verdict],
    [known, from_rest]: &[Vec<Verdict>; 2],
    kind: CaseKind,
    null: Option<CaseKind>,
) -> Option<Comparison> {
    let (form, others) = if kind.is_looped() {
        ("controller in the model", known)
    } else {
        ("separate runs from rest", from_rest)
    };
    let same = |v: &&Verdict| others.iter().any(|other| other.case == v.case);
    // Cases count that can be seen in both forms.
    let seen: Vec<&Verdict> = all.iter().filter(|v| v.is_visible).filter(same).collect();
    let other: Vec<&Verdict> =
        others.iter().filter(|o| seen.iter().any(|v| v.case == o.case)).collect();
    let nulls: Vec<&Verdict> =
        others.iter().filter(|v| null.is_some_and(|null| v.kind == null.name())).collect();
    (!other.is_empty() || !nulls.is_empty()).then(|| Comparison {
        form: form.to_owned(),
        right: [Rate::of(&seen, |v| v.is_right), Rate::of(&other, |v| v.is_right)],
        sure: sure(&other),
        blamed: Rate::of(&nulls, |v| 0.5 < v.blamed),
    })
}
