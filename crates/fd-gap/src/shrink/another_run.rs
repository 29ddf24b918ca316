//! Effects that belong to one run, in another one.
//!
//! A periodic force that nobody has synchronised with the log has another phase in another run, a drift goes on from a
//! time that nobody knows, and a path over time is another path. Forecasts that hold an effect to the clock of the run
//! that it was fitted to call it wrong for that alone, most of all where a log was cut in two and the clock of the second
//! part set to zero. Sizes and phases come from the part of a log that also tells its initial states, so that the
//! rest is still a forecast; a path that is drawn [anew](Paths::Anew) is none.
//!
//! *When not to use:* [`Paths::Anew`] where curves compete with laws: a path drawn anew follows anything.

use fd_effect::InAnotherRun;

use super::forecast::{Begun, STATES_SETTLED, Settled};
use crate::fit::{FitError, LeastSquares, Log, Minimum, Search, minimise_all};

/// What is made of paths over time in logs that were not fitted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Paths {
    /// They are as they were fitted.
    #[default]
    AsFitted,
    /// They are drawn anew through each log, all of it.
    Anew,
}

/// Values of the effects of a model in a log: those of the run that they were fitted to, but for what is another one in
/// this run.
pub(super) fn in_this_run(
    settled: Settled<'_>,
    log: &Log,
    begun: &Begun<'_>,
) -> Result<Vec<f64>, FitError> {
    let values: Vec<f64> = settled.effects.iter().map(|(_, value)| *value).collect();
    let is_path_free = settled.paths == Paths::Anew;
    let is_free: Vec<bool> = settled
        .effects
        .iter()
        .map(|(variable, _)| match variable.in_another_run {
            // A log that goes on where a fitted one ended is the same run.
            InAnotherRun::Another => log.is_own_run(),
            InAnotherRun::Path => is_path_free,
            InAnotherRun::Same | InAnotherRun::GoesOn => false,
        })
        .collect();
    if !is_free.contains(&true) {
        return Ok(values);
    }
    let effects = settled.effects.iter().zip(&is_free);
    let is_any_path = is_path_free && settled.effects.iter().any(|(v, _)| v.is_path());
    let mut problem = begun.free(&is_free, is_any_path)?;
    let origin = vec![0.0; problem.layout().unknowns() - values.len()];
    // A wave may have turned.
    let turned = effects.map(|((variable, value), free)| {
        let turns = *free && variable.in_another_run == InAnotherRun::Another;
        if turns { -value } else { *value }
    });
    let turned: Vec<f64> = turned.collect();
    let starts = [problem.place(&origin, &values), problem.place(&origin, &turned)];
    let search = Search { relative: STATES_SETTLED, ..Search::default() };
    let found = minimise_all(&mut problem, &starts, None, search).into_iter().flatten();
    let best = found.min_by(|a: &Minimum, b| a.cost.total_cmp(&b.cost));
    Ok(best.map_or(values, |best| problem.effect_values(&best.z)))
}
