//! What the log cannot tell from the leader.

use super::{
    result::{Cause, CauseId, RivalCause},
    settings::Settings,
    trial::Trial,
};
use crate::evidence::{SEPARATED, distance};

/// Rivals that are refitted to the simulation of the best cause.
const MOST_RIVALS: usize = 8;

/// The causes that this log cannot tell from the first, and of those that are nearly as
/// probable but could be told apart.
pub(super) fn separate(
    causes: &[(Option<usize>, Cause)],
    trials: &mut [Trial<'_>],
    settings: &Settings,
) -> (Vec<CauseId>, Vec<RivalCause>) {
    let Some((leader, first)) = causes.first() else { return (vec![], vec![]) };
    let (mut tied, mut rivals) = (vec![CauseId(0)], vec![]);
    let Some(leader) = *leader else { return (tied, rivals) };
    let Some(at) = trials[leader].best.clone() else { return (tied, rivals) };
    let mut truth = trials[leader].problem.clone();
    let near = causes.iter().enumerate().skip(1).take_while(|(_, (_, cause))| {
        first.log_evidence - cause.log_evidence < settings.bayes_factor.ln()
    });
    for (place, (trial, _)) in near.take(MOST_RIVALS) {
        let Some(rival) = trial.map(|trial| &trials[trial]) else { continue };
        let Some(rival_at) = &rival.best else { continue };
        let cause = CauseId(place);
        let distance = distance(&mut truth, &at, &rival.problem, rival_at);
        if distance < SEPARATED {
            tied.push(cause);
        } else {
            rivals.push(RivalCause { cause, distance });
        }
    }
    (tied, rivals)
}
