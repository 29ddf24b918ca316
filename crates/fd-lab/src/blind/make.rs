//! `fdiag-lab blind make`.

use std::{
    fs,
    path::{Path, PathBuf},
};

use fd_core::{Limits, Resource};
use rayon::prelude::*;

use super::{
    draw::draw,
    error::BlindError,
    files::{COMMITMENT, write, write_case},
    kind::CaseKind,
    oracle::oracle,
    random::Random,
    seal::SealKey,
    truth::{Scene, Truth},
};
use fdiag::Watcher;

/// Name of the file with the secret, beside the truths.
pub(super) const KEY: &str = "seal.key";
/// Name of the directory of cases.
pub(super) const CASES: &str = "cases";

/// What is to be made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Order {
    /// Everything but the secret follows from it.
    pub seed: u64,
    /// Number of cases of each kind.
    pub counts: Vec<(CaseKind, usize)>,
    /// Samples of each log.
    pub samples: usize,
    /// Whether to look for all rivals of each effect; without it, only whether it is visible.
    pub full_oracle: bool,
}

/// Fewest samples of a log: effects are told from noise over hundreds of them.
const FEWEST_SAMPLES: usize = 100;

impl Order {
    /// Checks what was ordered, before any directory is made.
    ///
    /// # Errors
    ///
    /// Returns an error when no case is ordered, logs are too short, or there would be more cases or
    /// samples than the limits allow.
    pub fn check(&self, limits: &Limits) -> Result<(), BlindError> {
        if self.samples < FEWEST_SAMPLES {
            let expected = "at least 100: effects are told from noise over hundreds of samples";
            return Err(BlindError::Order { what: "samples", expected, found: self.samples });
        }
        limits.check(Resource::Samples, "samples of each log", self.samples as f64)?;
        let cases: f64 = self.counts.iter().map(|(_, n)| *n as f64).sum();
        if cases < 1.0 {
            let expected = "at least 1 case of any kind";
            return Err(BlindError::Order { what: "cases", expected, found: 0 });
        }
        Ok(limits.check(Resource::Cases, "cases", cases)?)
    }
}

/// Makes cases in `out` and their truths in `truth`.
///
/// # Errors
///
/// Returns an error when there are cases already, the truth would lie among the cases, a case
/// cannot be drawn, or a file cannot be written.
pub fn make(
    order: &Order,
    out: &Path,
    truth: &Path,
    key: &SealKey,
    watcher: &impl Watcher,
) -> Result<Vec<Truth>, BlindError> {
    order.check(&Limits::default())?;
    let cases = out.join(CASES);
    for directory in [&cases, truth] {
        if directory.exists() {
            return Err(BlindError::Exists { directory: directory.to_owned() });
        }
    }
    if truth.starts_with(&cases) {
        return Err(BlindError::TruthBeside { directory: cases });
    }
    fs::create_dir_all(&cases).map_err(BlindError::file(&cases))?;
    fs::create_dir_all(truth).map_err(BlindError::file(truth))?;
    write(&truth.join(KEY), key.to_hex())?;

    let kinds = order.counts.iter().flat_map(|(kind, n)| (0..*n).map(move |i| (*kind, i)));
    let kinds: Vec<(CaseKind, usize)> = kinds.collect();
    watcher.begin(kinds.len() as u64, 0);
    // The order of the cases tells nothing of their kinds.
    let mut numbers: Vec<usize> = (1..=kinds.len()).collect();
    Random::named(order.seed, "order").shuffle(&mut numbers);
    let made: Result<Vec<Truth>, BlindError> = kinds
        .par_iter()
        .zip(&numbers)
        .map(|((kind, i), number)| {
            let case = format!("case-{number:04}");
            let made = one(order, *kind, *i, &case, &cases, truth, key)?;
            watcher.advance();
            Ok(made)
        })
        .collect();
    let mut made = made?;
    made.sort_by(|a, b| a.case.cmp(&b.case));
    Ok(made)
}

fn one(
    order: &Order,
    kind: CaseKind,
    i: usize,
    case: &str,
    cases: &Path,
    truths: &Path,
    key: &SealKey,
) -> Result<Truth, BlindError> {
    let (mut truth, model) = draw(order.seed, kind, i, order.samples)?;
    case.clone_into(&mut truth.case);
    let scene = Scene::new(&truth, &model)?;
    let directory = cases.join(case);
    write_case(&scene, &directory)?
        .ok_or_else(|| BlindError::content(case.as_ref(), "the plant diverges"))?;
    let seen = oracle(&scene, order.full_oracle)?;
    drop(scene);
    truth.oracle = Some(seen);
    let text = serde_json::to_string(&truth).map_err(|e| BlindError::content(truths, e))?;
    let (sealed, commitment) = key.seal(case, &text);
    write(&directory.join(COMMITMENT), commitment)?;
    write(&sealed_file(truths, case), sealed)?;
    Ok(truth)
}

/// Where the truth of a case is.
pub(super) fn sealed_file(truths: &Path, case: &str) -> PathBuf {
    truths.join(format!("{case}.sealed"))
}
