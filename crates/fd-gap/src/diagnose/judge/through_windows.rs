//! Fits that a lost free run leads astray go on through windows.
//!
//! Where the free run without any effect is lost, as that of a plant that swings or falls, its errors and slopes say little of
//! what is missing, and fits stay in the valley in which they begin. In windows states begin anew and the valleys are wide:
//! there the same candidates are searched, and from there their fits go on to the free run. Only where that is lost with the
//! best law as well, windows are what is judged.

use super::horizons::{is_lost, windows};
use crate::{
    diagnose::{
        context::Context,
        prepare::prepare,
        search::{carried_on, search},
        weigh::{Weighed, singles::weigh_singles, weigh},
    },
    fit::{FitError, Horizon},
};

/// The windows to go through, where fits are to be made in free runs and that without any effect is lost.
pub(super) fn windows_where_lost(
    free: &Weighed<'_>,
    horizons: &[Horizon],
    context: &Context<'_>,
) -> Option<Horizon> {
    let windows = windows(horizons);
    let may_help = context.settings.horizon == Horizon::FreeRun && windows != Horizon::FreeRun;
    let singles = &free.singles;
    (may_help && is_lost(&singles.refit.errors, &singles.base)).then_some(windows)
}

/// The same, fitted through windows; and whether these are to be judged, since the free run stays lost.
pub(super) fn through_windows<'a>(
    free: Weighed<'a>,
    windows: Horizon,
    context: &Context<'a>,
) -> Result<(Weighed<'a>, bool), FitError> {
    let settings = context.settings;
    let prepared = match prepare(&context.case, windows) {
        // What cannot begin in the middle of a log, as a linear model of whole runs, stays with the free run.
        Err(FitError::Diverged) => return Ok((free, false)),
        prepared => prepared?,
    };
    let known = search(prepared, &free.singles.searched.trials, context)?;
    let searched = carried_on(free.singles.searched, &known.trials, context)?;
    let free = weigh_singles(searched, context.candidates)?;
    let law = free.first_law();
    if is_lost(law.as_ref().map_or(&free.refit.errors, |law| &law.errors), &free.base) {
        let singles = weigh_singles(known, context.candidates)?;
        return Ok((Weighed::of(singles, Vec::new(), settings), true));
    }
    let alone = Weighed::of(free, Vec::new(), settings);
    let weighed = if alone.is_far() { alone } else { weigh(alone.singles.searched, context)? };
    Ok((weighed, false))
}
