//! Which held-out logs begin elsewhere than the model says, and when.

use fd_effect::InAnotherRun;
use fd_sim::simulate::Simulator;

use super::{
    Settled,
    forecast::{Forecast, forecast_one},
};
use crate::{
    evidence::grades::BEYOND_DOUBT,
    fit::{FitError, Horizon, Log},
    quality::REACHED,
};

/// Part of the squares of the forecast that may be left with another start.
const LEFT: f64 = 0.25;
/// Times that have passed before a log begins, in eighths of its length, from which to seek the best …
const PASSED: [usize; 15] = [0, 1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 24, 32, 48, 64];
/// … by halving the distance so many times.
const HALVED: usize = 5;

/// The held-out `logs` as they begin, where the free run of the `best` answer misses one and another beginning
/// mends that: in motion, or, for what goes on from run to run, some time after it began. It has to explain the first
/// quarter clearly better (an F-test), and with it the rest, which it has not seen, is forecast with a quarter of the
/// squares.
///
/// An answer that forecasts well from the stated start is never asked, so that a free start cannot take the place
/// of a bias that has been found.
pub(crate) fn as_begun(
    nominal: &dyn Simulator,
    best: Settled<'_>,
    mut logs: Vec<Log>,
    sigma: &[f64],
) -> Result<Vec<Log>, FitError> {
    let goes_on = best.effects.iter().any(|(v, _)| v.in_another_run == InAnotherRun::GoesOn);
    for log in &mut logs {
        let may_go_on = goes_on && log.is_own_run();
        if log.is_in_motion && !may_go_on {
            continue;
        }
        let run = |log: &Log| forecast_one(nominal, best, log, Horizon::FreeRun, sigma);
        let Some(mut forecast) = run(log)? else { continue };
        let is_missed = |forecast: &Forecast| REACHED * REACHED <= forecast.mean_square();
        if !log.is_in_motion && is_missed(&forecast) {
            let free = log.clone().in_motion();
            if let Some(found) = run(&free)?.filter(|found| is_better(found, &forecast, 0)) {
                (*log, forecast) = (free, found);
            }
        }
        if may_go_on && is_missed(&forecast) {
            // Where a start was free in vain, it may be free with the right clock.
            let free = (!log.is_in_motion).then(|| log.clone().in_motion());
            for known in std::iter::once(log.clone()).chain(free) {
                let later = later(&known, run)?;
                if let Some((later, found)) =
                    later.filter(|(_, found)| is_better(found, &forecast, 1))
                {
                    (*log, forecast) = (later, found);
                }
            }
        }
    }
    Ok(logs)
}

/// The log with the clock that explains its first quarter best.
fn later(
    log: &Log,
    run: impl Fn(&Log) -> Result<Option<Forecast>, FitError>,
) -> Result<Option<(Log, Forecast)>, FitError> {
    let squares = |forecast: &Forecast| forecast.begin.squares;
    let mut best: Option<(usize, Forecast)> = None;
    let look = |first: usize, best: &mut Option<(usize, Forecast)>| -> Result<(), FitError> {
        let found = run(&log.clone().begun_at(first))?;
        let is_best = |found: &Forecast| {
            best.as_ref().is_none_or(|(_, known)| squares(found) < squares(known))
        };
        if let Some(found) = found.filter(is_best) {
            *best = Some((first, found));
        }
        Ok(())
    };
    for eighths in PASSED {
        look((eighths * log.samples()).div_ceil(8), &mut best)?;
    }
    let Some((mut first, _)) = best else { return Ok(None) };
    let mut step = log.samples().max(first / 2) / 8;
    for _ in 0..HALVED {
        step /= 2;
        for nearby in [first.saturating_sub(step), first + step] {
            look(nearby, &mut best)?;
        }
        first = best.as_ref().map_or(first, |(first, _)| *first);
    }
    Ok(best.map(|(first, found)| (log.clone().begun_at(first), found)))
}

/// Whether a beginning with so many `more` unknowns than its initial states is to be believed.
fn is_better(free: &Forecast, stated: &Forecast, more: usize) -> bool {
    let (n, unknowns) = (free.begin.samples as f64, (free.begin.unknowns + more) as f64);
    let gain = stated.begin.squares - free.begin.squares;
    let is_sure = unknowns * (n.ln() + BEYOND_DOUBT) * free.begin.squares < n * gain;
    is_sure && free.mean_square() < LEFT * stated.mean_square()
}
