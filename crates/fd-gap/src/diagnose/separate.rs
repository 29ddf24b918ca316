//! What the log cannot tell from the leader.

use super::{result::Cause, settings::Settings, trial::Trial};
use crate::evidence::{SEPARATED, distance};

/// Rivals that are refitted to the simulation of the best cause.
const MOST_RIVALS: usize = 8;

/// Places of the causes that this log cannot tell from the first, and of those that are nearly as
/// probable but could be told apart.
pub(super) fn separate(
    causes: &[(usize, Cause)],
    trials: &mut [Trial<'_>],
    settings: &Settings,
) -> (Vec<usize>, Vec<(usize, f64)>) {
    let Some((leader, first)) = causes.first() else { return (vec![], vec![]) };
    let (mut tied, mut rivals) = (vec![0], vec![]);
    let Some(at) = trials[*leader].best.clone() else { return (tied, rivals) };
    let mut truth = trials[*leader].problem.clone();
    let near = causes.iter().enumerate().skip(1).take_while(|(_, (_, cause))| {
        first.log_evidence - cause.log_evidence < settings.bayes_factor.ln()
    });
    for (place, (trial, _)) in near.take(MOST_RIVALS) {
        let Some(rival_at) = &trials[*trial].best else { continue };
        let left = distance(&mut truth, &at, &trials[*trial].problem, rival_at);
        if left < SEPARATED {
            tied.push(place);
        } else {
            rivals.push((place, left));
        }
    }
    (tied, rivals)
}
