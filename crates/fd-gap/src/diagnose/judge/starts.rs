//! Which reading of the starts of the logs to believe.

use super::judged::Judged;
use crate::{
    diagnose::{
        prepare::{
            Prepared,
            start::{needed, squares, squares_of},
        },
        search::searched::Searched,
    },
    evidence::grades::BEYOND_DOUBT,
    fit::FitError,
};

/// Whether free starts could gain enough to be believed: not where the noise of all outputs is stated and the answer
/// with stated starts leaves so little more than noise, and by chance less, that many unknown states would not be worth it.
pub(in crate::diagnose) fn is_open(stated: &Judged<'_>, free: &Prepared) -> bool {
    let plan = free.null.problem.plan();
    let n = plan.measured() as f64;
    let errors = stated.best.errors.iter().flatten().flatten().filter(|e| e.is_finite());
    let left = errors.map(|e| e * e).sum::<f64>() / n;
    let most = n * left.max(1.0).ln() + (2.0 * n).sqrt();
    let is_known = stated.singles.searched.noise.stated.iter().all(Option::is_some);
    !is_known || needed(plan) < most
}

/// Whether free starts alone explain so much more than the best single effect does from stated ones that chance with so many
/// more unknowns does not explain it: no other effect has to be tried beside that one.
pub(in crate::diagnose) fn is_settled(
    stated: &Searched<'_>,
    free: &Prepared,
) -> Result<bool, FitError> {
    let (plan, sigma) = (free.null.problem.plan(), &stated.noise.sigma);
    let before = squares(&stated.best_errors()?, sigma, sigma);
    let after = squares_of(&free.null, sigma).ok_or(FitError::Diverged)?;
    Ok(needed(plan) < plan.measured() as f64 * (before / after).ln())
}

/// The judgement to believe: that of free starts only where its best answer leaves so much less than the other
/// one's that chance with so many more unknowns does not explain it, or where it is the plainer one, and as good: fewer starts
/// and effects together than the other needs effects, or one effect less than several. A log that begins elsewhere is an
/// everyday thing; to take its start for one of two effects is not.
pub(in crate::diagnose) fn prefer<'a>(stated: Judged<'a>, free: Judged<'a>) -> Judged<'a> {
    let sigma = &stated.singles.searched.noise.sigma;
    let squares = |judged: &Judged<'_>| {
        squares(&judged.best.errors, &judged.singles.searched.noise.sigma, sigma)
    };
    let plan = free.singles.base.plan();
    let (n, unknowns) = (plan.measured() as f64, plan.own_variables().count() as f64);
    let gain = n * (squares(&stated) / squares(&free)).ln();
    let is_plainer = free.best.effects as f64 + unknowns < stated.best.effects as f64
        || 1 < stated.best.effects && free.best.effects < stated.best.effects;
    let least = if is_plainer { -BEYOND_DOUBT } else { needed(plan) };
    if least < gain { free } else { stated }
}
