//! What a study chooses by itself from the model and the logs.

use fd_gap::{
    diagnose::{Beginning, Settings},
    fit::{FitError, Horizon, Log},
    quality::{Defect, Finding},
};
use fd_model::{Record, SampleTime};
use fd_sim::simulate::Nominal;

use super::{
    data::Data,
    memory::Memory,
    request::{HorizonChoice, Request, StartsChoice},
};

/// Horizons of automatic windows, in memories of the model.
const WINDOWS: [f64; 2] = [1.0, 5.0];
/// Fewest samples of a window.
const SHORTEST_WINDOW: usize = 20;
/// Windows in the shortest log.
const FEWEST_WINDOWS: usize = 3;
/// A log that lasts for less than this part of the memory of the model is short.
const LEAST_OF_MEMORY: f64 = 1.0 / 3.0;

/// Inputs of the longest log, row by row, and its samples.
pub(super) fn longest(logs: &[Log]) -> (Vec<f64>, usize) {
    let longest = logs.iter().max_by_key(|log| log.samples());
    longest.map_or_else(Default::default, |log| {
        let rows = (0..log.samples()).flat_map(|k| log.input(k).iter().copied());
        (rows.collect(), log.samples())
    })
}

/// A log that ends before the initial state is forgotten says more of that than of the plant; or the model has
/// something in another unit.
pub(super) fn short_log(data: &Data, memory: Memory, ts: SampleTime) -> Option<Finding> {
    let numbered = data.fit.iter().enumerate();
    let (log, record) = numbered.max_by_key(|(_, record)| record.len())?;
    let (seconds, memory) = (record.len() as f64 * ts.seconds(), memory.slowest?);
    let channel = record.outputs().first()?.name.clone();
    let defect = Defect::Short { seconds, memory };
    let is_short = data.long.is_none() && seconds < LEAST_OF_MEMORY * memory;
    is_short.then_some(Finding { log: log + 1, channel, defect })
}

/// The settings that a diagnosis chooses by itself, with all defaults, for one log to fit and one to
/// hold out.
///
/// # Errors
///
/// Returns an error when the model cannot be simulated or the logs do not fit it.
pub fn automatic_settings(nominal: &dyn Nominal, logs: &[Record; 2]) -> Result<Settings, FitError> {
    let ts = logs[0].ts();
    let simulator = nominal.simulator(ts)?;
    let [fitted, held_out] =
        [Log::new(&logs[0], &*simulator, 1)?, Log::new(&logs[1], &*simulator, 2)?];
    let logs = [vec![fitted], vec![held_out]];
    let (u, samples) = longest(&logs[0]);
    let memory = Memory::of(&*simulator, &u, samples);
    let request = Request::new("", Vec::<std::path::PathBuf>::new());
    Ok(settings(&request, memory, &logs, ts))
}

pub(super) fn settings(
    request: &Request,
    memory: Memory,
    logs: &[Vec<Log>; 2],
    ts: SampleTime,
) -> Settings {
    let shortest = logs.iter().flatten().map(Log::samples).min().unwrap_or(0);
    let windows = |seconds: f64| {
        let most = (shortest / FEWEST_WINDOWS).max(SHORTEST_WINDOW);
        Horizon::Windows { samples: samples(seconds, ts).clamp(SHORTEST_WINDOW, most) }
    };
    let horizon = match (request.horizon, memory) {
        // Windows throw away what is slow, and what lags and delays remember; they are for plants that
        // run away from any start. A free run that is lost otherwise is noticed by the diagnosis.
        (HorizonChoice::Free, _) | (HorizonChoice::Auto, Memory { runs_away: false, .. }) => {
            Horizon::FreeRun
        }
        (HorizonChoice::Seconds(seconds), _) => {
            Horizon::Windows { samples: samples(seconds, ts).max(2) }
        }
        (HorizonChoice::Auto, Memory { seconds, .. }) => {
            let tenth = 0.1 * shortest as f64 * ts.seconds();
            windows(seconds.map_or(tenth, |seconds| WINDOWS[1] * seconds))
        }
    };
    let mut report_horizons = vec![horizon];
    let others = memory.seconds.into_iter().flat_map(|s| WINDOWS.map(|n| windows(n * s)));
    for other in std::iter::once(Horizon::FreeRun).chain(others) {
        if !report_horizons.contains(&other) {
            report_horizons.push(other);
        }
    }
    let beginning = match request.starts {
        StartsChoice::Either => Beginning::Either,
        StartsChoice::Stated => Beginning::AsStated,
        StartsChoice::Free => Beginning::InMotion,
    };
    let Request { seed, controller_sees, .. } = *request;
    Settings { horizon, report_horizons, seed, beginning, controller_sees, ..Settings::default() }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
fn samples(seconds: f64, ts: SampleTime) -> usize {
    (seconds / ts.seconds()).round() as usize
}
