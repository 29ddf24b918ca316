//! Which held-out logs begin elsewhere than the model says.

use fd_sim::simulate::Simulator;

use super::{
    Settled,
    forecast::{Forecast, forecast_one},
};
use crate::fit::{FitError, Horizon, Log};

/// What a free start must gain, per unknown, beyond `ln n`, as where fitted logs begin in motion.
const SURE: f64 = 10.0;
/// Times the noise in a forecast from which its start is doubted.
const MISSED: f64 = 2.0;
/// Part of the squares of the forecast that may be left with another start.
const LEFT: f64 = 0.25;

/// The held-out `logs`, in motion where the free run of the `best` answer misses one and a free start mends that:
/// it explains the first quarter clearly better (an F-test), and with it the rest, which it has not seen, is forecast with
/// a quarter of the squares.
///
/// An answer that forecasts well from the stated start is never asked, so that a free start cannot take the place
/// of a bias that has been found.
pub(crate) fn with_free_starts(
    nominal: &dyn Simulator,
    best: Settled<'_>,
    mut logs: Vec<Log>,
    sigma: &[f64],
) -> Result<Vec<Log>, FitError> {
    for log in &mut logs {
        if log.is_in_motion {
            continue;
        }
        let run = |log: &Log| forecast_one(nominal, best, log, Horizon::FreeRun, sigma);
        let Some(stated) = run(log)? else { continue };
        if stated.mean_square() < MISSED * MISSED {
            continue;
        }
        let free = log.clone().in_motion();
        if run(&free)?.is_some_and(|free| is_better(&free, &stated)) {
            *log = free;
        }
    }
    Ok(logs)
}

fn is_better(free: &Forecast, stated: &Forecast) -> bool {
    let (n, unknowns) = (free.begin.samples as f64, free.begin.unknowns as f64);
    let gain = stated.begin.squares - free.begin.squares;
    let is_sure = unknowns * (n.ln() + SURE) * free.begin.squares < n * gain;
    is_sure && free.mean_square() < LEFT * stated.mean_square()
}
