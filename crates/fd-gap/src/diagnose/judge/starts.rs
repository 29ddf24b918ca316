//! Which reading of the starts of the logs to believe.

use super::judged::Judged;
use crate::diagnose::prepare::start::SURE;

/// The judgement to believe: that of free starts only where its best answer leaves so much less than the other
/// one's that chance with so many more unknowns does not explain it, or where it is the plainer one: fewer starts and
/// effects together than the other needs effects, and as good.
pub(in crate::diagnose) fn prefer<'a>(stated: Judged<'a>, free: Judged<'a>) -> Judged<'a> {
    let squares = |judged: &Judged<'_>, sigma: &[f64]| -> f64 {
        let own = &judged.singles.searched.noise.sigma;
        let of = |((signals, own), common): ((&Vec<Vec<f64>>, &f64), &f64)| -> f64 {
            let finite = signals.iter().flatten().filter(|e| e.is_finite());
            finite.map(|e| (e * own / common).powi(2)).sum()
        };
        judged.best.errors.iter().zip(own).zip(sigma).map(of).sum()
    };
    let sigma = stated.singles.searched.noise.sigma.clone();
    let plan = free.singles.base.plan();
    let (n, unknowns) = (plan.measured() as f64, plan.own_variables().count() as f64);
    let gain = n * (squares(&stated, &sigma) / squares(&free, &sigma)).ln();
    let is_plainer = free.best.effects as f64 + unknowns < stated.best.effects as f64;
    let least = if is_plainer { -SURE } else { unknowns * (n.ln() + SURE) };
    if least < gain { free } else { stated }
}
