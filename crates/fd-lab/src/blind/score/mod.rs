//! `fdiag-lab blind score`.

mod classes;
mod judge;
mod report;
mod statistics;
mod threshold;

use std::{fs, path::Path};

use fd_numeric::{median, quantile};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use self::judge::judge;
use self::threshold::{FALSE_ABSTENTION, SURE};
pub use self::{
    classes::{ClassScore, Comparison},
    judge::{OfSeveral, Verdict},
    statistics::{Bin, Calibration, Rate},
};
use super::{
    answer::{Answer, read_answers},
    error::BlindError,
    feature::Feature,
    files::{Case, Variant, answers},
    make::{KEY, sealed_file},
    oracle::SEPARATED,
    run::cases,
    seal::SealKey,
    truth::Truth,
};
use fdiag::Watcher;

/// Share of the cases for which precision is counted.
const ANSWERED: f64 = 0.6;
/// Squares of the noise from which effects are counted apart.
const DISTANCES: [f64; 5] = [SEPARATED, 25.0, 62.0, 250.0, 2500.0];

/// All that came out of a blind test.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// Version of this format.
    pub version: u32,
    /// Cases with a truth and an answer.
    pub cases: usize,
    /// Cases without an answer.
    pub unanswered: usize,
    /// Diagnoses that failed.
    pub failed: usize,
    /// Single effects that leave no trace, of all single effects.
    pub invisible: Rate,
    /// The first cause is right, or not to be told from the truth, on visible single effects.
    pub top: Rate,
    /// The first cause has the very label and site.
    pub strict_top: Rate,
    /// The same for white and for coloured noise.
    pub top_by_noise: [Rate; 2],
    /// Precision of the most sure three fifths of the answers with one cause.
    pub precision: Rate,
    /// Share of answers with one cause and a probability above 0.9, and their precision.
    pub sure: [Rate; 2],
    /// Cases without a gap blamed with a probability above one half: white, coloured noise.
    pub blamed: [Rate; 2],
    /// Withheld classes that nothing mimics, told at 3 % false abstention.
    pub withheld: Rate,
    /// The same, by the decision of the diagnosis itself, and its false abstentions.
    pub withheld_own: [Rate; 2],
    /// Withheld effects that a single effect of the library mimics.
    pub mimicked: Rate,
    /// Calibration of the group posterior: matched laws, mismatched laws.
    pub group: [Calibration; 2],
    /// Calibration of the label posterior: matched laws, mismatched laws.
    pub label: [Calibration; 2],
    /// Law mismatch: label, mechanism and place, side.
    pub mismatch: [Rate; 3],
    /// Single effects: mechanism and place, side.
    pub place: [Rate; 2],
    /// Two effects: both, both or not to be told from them, at least one, noise floor reached.
    pub pairs: [Rate; 4],
    /// Median share of the held-out gap after the parameter refit that the named effect is said to
    /// close, on visible single effects.
    pub closed: f64,
    /// Intervals that contain the real share.
    pub coverage: Rate,
    /// The same by kind of case.
    pub closed_by_kind: Vec<ClosedOf>,
    /// The first cause is right on visible single effects of the library in white and in coloured
    /// noise, by what they leave.
    pub top_by_distance: Vec<BySquares>,
    /// Withheld classes told at the threshold of few false abstentions and by the diagnosis itself, by
    /// what the nearest known effect leaves.
    pub told_by_nearest: Vec<BySquares>,
    /// Median and 90 % quantile of the time of a diagnosis, in seconds.
    pub seconds: [f64; 2],
    /// Named rightly by the refit, by the sparse regression.
    pub baseline_top: [Rate; 2],
    /// Median share closed by refit, black box, sparse regression.
    pub baseline_closed: [f64; 3],
    /// Logs as people have them, class by class.
    pub classes: Vec<ClassScore>,
    /// Case by case.
    pub verdicts: Vec<Verdict>,
}

/// How much of the gap is closed, on visible effects of one kind of case.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ClosedOf {
    /// The kind.
    pub kind: String,
    /// Median of what is said.
    pub stated: f64,
    /// Median of what is true.
    pub real: f64,
    /// Intervals that contain what is true.
    pub coverage: Rate,
}

/// Two rates among cases of which something leaves so many squares of the noise.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BySquares {
    /// The least that it leaves; the most is the least of the next.
    pub least: f64,
    /// The rates.
    pub rates: [Rate; 2],
}

/// Opens all truths, checks that they are those that were committed to, and scores the answers to cases of this
/// form, by the method `without` something, if that is asked for; those of the other forms stand beside them in the
/// table of classes.
///
/// # Errors
///
/// Returns an error when a file cannot be read or a truth does not match its commitment.
pub fn score(
    directory: &Path,
    truths: &Path,
    form: Variant,
    without: Option<Feature>,
    watcher: &impl Watcher,
) -> Result<Score, BlindError> {
    let file = truths.join(KEY);
    let key = fs::read_to_string(&file).map_err(BlindError::file(&file))?;
    let key = SealKey::parse(&key)
        .ok_or_else(|| BlindError::content(&file, "expected 64 hexadecimal digits"))?;
    let cases = cases(directory)?;
    let truths: Result<Vec<Truth>, BlindError> = cases
        .iter()
        .map(|case| {
            let file = sealed_file(truths, &case.name);
            let sealed = fs::read(&file).map_err(BlindError::file(&file))?;
            let text = key.open(&case.name, &sealed, &case.commitment()?)?;
            serde_json::from_str(&text).map_err(|e| BlindError::content(&file, e))
        })
        .collect();
    let all: Vec<(&Case, Truth)> = cases.iter().zip(truths?).collect();
    watcher.begin(all.len() as u64, 0);
    let judged = |variant: Variant| -> Result<Vec<Option<Verdict>>, BlindError> {
        let answers = read_answers(&directory.join(answers(variant, without)))?;
        all.par_iter()
            .map(|(case, truth)| {
                let answer = answers.iter().find(|answer| answer.case == case.name);
                let of_case = |e| BlindError::Case { case: case.name.clone(), error: Box::new(e) };
                let judged = answer.map(|answer| judge(Some((case, variant)), truth, answer));
                let verdict = judged.transpose().map_err(of_case)?;
                if variant == form {
                    watcher.advance();
                }
                Ok(verdict)
            })
            .collect()
    };
    let of_form = judged(form)?;
    let unanswered = of_form.iter().filter(|verdict| verdict.is_none()).count();
    let verdicts: Vec<Verdict> = of_form.into_iter().flatten().collect();
    let [known, from_rest] = [Variant::KnownController, Variant::FromRest].map(judged);
    let others = [known?, from_rest?].map(|all| all.into_iter().flatten().collect::<Vec<_>>());
    let classes = classes::all(&verdicts, &others);
    Ok(Score { classes, ..summarise(verdicts, unanswered) })
}

/// Scores answers next to truths that lie open, without refits: what is not exact is wrong unless
/// the oracle of the truth has it among its ties.
///
/// # Errors
///
/// Never, as nothing is read.
pub fn score_open(pairs: &[(Truth, Answer)]) -> Result<Score, BlindError> {
    let verdicts: Result<Vec<Verdict>, BlindError> =
        pairs.iter().map(|(truth, answer)| judge(None, truth, answer)).collect();
    let verdicts = verdicts?;
    let classes = classes::all(&verdicts, &[vec![], vec![]]);
    Ok(Score { classes, ..summarise(verdicts, 0) })
}

fn summarise(all: Vec<Verdict>, unanswered: usize) -> Score {
    // The tables of the first kinds are of these alone.
    let verdicts: Vec<Verdict> = all.iter().filter(|v| v.is_plain()).cloned().collect();
    let of = |kind: &str| -> Vec<&Verdict> { verdicts.iter().filter(|v| v.kind == kind).collect() };
    let visible = |kind: &str| -> Vec<&Verdict> {
        of(kind).into_iter().filter(|verdict| verdict.is_visible).collect()
    };
    let (all_singles, singles, mismatch) = (of("single"), visible("single"), visible("mismatch"));
    let pairs = visible("pair");
    let withheld = visible("withheld");
    let strange: Vec<&Verdict> = withheld.iter().copied().filter(|v| !v.is_mimicked).collect();
    let only = |all: &[&Verdict], coloured: bool| -> Vec<Verdict> {
        all.iter().filter(|v| v.coloured == coloured).map(|v| (*v).clone()).collect()
    };

    let mut alone: Vec<&Verdict> = singles.iter().copied().filter(|v| v.is_alone).collect();
    alone.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
    let wanted = (ANSWERED * singles.len() as f64).round() as usize;
    let most_sure = &alone[..wanted.min(alone.len())];
    let is_sure = |v: &&Verdict| SURE < v.probability && !v.says_none;
    let sure: Vec<&Verdict> = alone.iter().copied().filter(is_sure).collect();

    let mut known: Vec<f64> = singles.iter().map(|v| v.none_score).collect();
    let threshold = quantile(&mut known, 1.0 - FALSE_ABSTENTION);
    let calibration = |all: &[&Verdict], group: bool| {
        let said = all.iter().filter(|v| v.blamed > 0.5);
        let pairs: Vec<(f64, bool)> = said
            .map(|v| {
                if group {
                    (v.group_probability, v.is_group_right)
                } else {
                    (v.probability, v.is_right)
                }
            })
            .collect();
        Calibration::of(&pairs)
    };
    let none = of("none");
    let covered: Vec<bool> = verdicts.iter().filter_map(|v| v.is_covered).collect();
    let closed_of = |(kind, all): (&str, &Vec<&Verdict>)| ClosedOf {
        kind: kind.to_owned(),
        stated: median(&mut all.iter().filter_map(|v| v.closed).collect()),
        real: median(&mut all.iter().filter_map(|v| v.really_closed).collect()),
        coverage: Rate::of(&all.iter().filter_map(|v| v.is_covered).collect::<Vec<_>>(), |c| *c),
    };
    let kinds =
        [("single", &singles), ("mismatch", &mismatch), ("pair", &pairs), ("withheld", &withheld)];
    let range = |i: usize| DISTANCES[i]..DISTANCES.get(i + 1).copied().unwrap_or(f64::INFINITY);
    let top_of = |i: usize| {
        let is_in = |v: &&&Verdict| range(i).contains(&v.distance);
        let all: Vec<&Verdict> = singles.iter().filter(is_in).copied().collect();
        let rates = [false, true].map(|c| Rate::of(&only(&all, c), |v| v.is_right));
        BySquares { least: DISTANCES[i], rates }
    };
    let told_of = |i: usize| {
        let is_in = |v: &&&Verdict| v.nearest.is_some_and(|nearest| range(i).contains(&nearest));
        let all: Vec<&Verdict> = strange.iter().filter(is_in).copied().collect();
        let rates = [Rate::of(&all, |v| threshold < v.none_score), Rate::of(&all, |v| v.says_none)];
        BySquares { least: DISTANCES[i], rates }
    };
    let mut times: Vec<f64> = verdicts.iter().map(|v| v.seconds).collect();
    let closed_by =
        |i: usize| median(&mut singles.iter().filter_map(|v| v.baseline_closed[i]).collect());
    Score {
        version: 1,
        cases: all.len(),
        unanswered,
        failed: all.iter().filter(|v| v.error.is_some()).count(),
        invisible: Rate::of(&all_singles, |v| !v.is_visible),
        top: Rate::of(&singles, |v| v.is_right),
        strict_top: Rate::of(&singles, |v| v.is_exact),
        top_by_noise: [false, true].map(|c| Rate::of(&only(&singles, c), |v| v.is_right)),
        precision: Rate::of(most_sure, |v| v.is_right),
        sure: [Rate::new(sure.len(), singles.len()), Rate::of(&sure, |v| v.is_right)],
        blamed: [false, true].map(|c| Rate::of(&only(&none, c), |v| 0.5 < v.blamed)),
        withheld: Rate::of(&strange, |v| threshold < v.none_score),
        withheld_own: [Rate::of(&strange, |v| v.says_none), Rate::of(&singles, |v| v.says_none)],
        mimicked: Rate::of(&withheld, |v| v.is_mimicked),
        group: [calibration(&singles, true), calibration(&mismatch, true)],
        label: [calibration(&singles, false), calibration(&mismatch, false)],
        mismatch: [
            Rate::of(&mismatch, |v| v.is_right),
            Rate::of(&mismatch, |v| v.is_group_right),
            Rate::of(&mismatch, |v| v.is_side_right),
        ],
        place: [Rate::of(&singles, |v| v.is_group_right), Rate::of(&singles, |v| v.is_side_right)],
        pairs: [
            Rate::of(&pairs, |v| v.is_pair_exact),
            Rate::of(&pairs, |v| v.is_pair_right),
            Rate::of(&pairs, |v| v.is_half_exact),
            Rate::of(&pairs, |v| v.is_floor_reached),
        ],
        closed: median(&mut singles.iter().filter_map(|v| v.closed).collect()),
        coverage: Rate::of(&covered, |covered| *covered),
        closed_by_kind: kinds.into_iter().map(closed_of).collect(),
        top_by_distance: (0..DISTANCES.len()).map(top_of).collect(),
        told_by_nearest: (0..DISTANCES.len()).map(told_of).collect(),
        seconds: [median(&mut times), quantile(&mut times, 0.9)],
        baseline_top: [0, 1].map(|i| Rate::of(&singles, |v| v.baseline_right[i])),
        baseline_closed: [0, 1, 2].map(closed_by),
        classes: Vec::new(),
        verdicts: all,
    }
}
