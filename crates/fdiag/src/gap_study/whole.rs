//! All rows of long logs, judged by what their stretches have taught.

use fd_gap::{
    diagnose::Diagnosis,
    fit::{FitError, Horizon, Log},
};
use fd_model::Record;
use fd_numeric::{median, rms};
use fd_sim::simulate::{Nominal, Simulator};
use schemars::JsonSchema;
use serde::Serialize;

use super::{data::Long, log_part::Role, said::Said};

/// Rows that are simulated at a time: their slopes must fit into memory.
const AT_A_TIME: usize = 20_000;
/// Errors of a window, over their median, from which it is one of its own kind.
const OTHER: f64 = 3.0;
/// Most windows that are listed, and added to the fit.
const MOST: usize = 3;

/// How the answer, found on stretches, does on all rows. In each window the first half tells the states, and the
/// second half is forecast.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Whole {
    /// Rows of all logs.
    pub rows: usize,
    /// Rows of the stretches that models were fitted to.
    pub fitted: usize,
    /// Rows of a window.
    pub window: usize,
    /// Windows that were forecast.
    pub windows: usize,
    /// Median over the windows of the error of the refitted model, in units of the noise.
    pub refitted: f64,
    /// The same with the best explanation.
    pub explained: f64,
    /// The windows that the best explanation fits worst, if they are unlike the others, the worst first.
    pub unlike: Vec<Window>,
    /// How many there are of these.
    pub unlike_count: usize,
}

/// A window of a long log.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Window {
    /// Name of the file.
    pub file: String,
    /// First row on the grid of the file, and one after the last.
    pub rows: [usize; 2],
    /// Error of the refitted model, in units of the noise.
    pub refitted: f64,
    /// The same with the best explanation.
    pub explained: f64,
    /// Place among the parts of the long logs, and the rows in that part; not serialised.
    #[serde(skip)]
    pub(super) place: (usize, [usize; 2]),
}

/// Forecasts all windows of all logs.
pub(super) fn judge(
    long: &Long,
    nominal: &dyn Nominal,
    diagnosis: &Diagnosis,
    fitted: usize,
    followed: impl Fn(&Record) -> Record,
) -> Result<Option<Whole>, FitError> {
    let Some(ts) = long.parts.first().map(|(_, record)| record.ts()) else { return Ok(None) };
    let plain = nominal.simulator(ts)?;
    let refit = Said::of(nominal, &diagnosis.refit, ts)?;
    let best = Said::of(nominal, &diagnosis.best, ts)?;
    let mut windows = Vec::new();
    let piece = AT_A_TIME.next_multiple_of(long.length);
    for (index, (part, record)) in long.parts.iter().enumerate() {
        for from in (0..record.len()).step_by(piece) {
            let slice = followed(&record.slice(from, from + piece));
            let log = Log::new(&slice, &*plain, index + 1)?;
            let errors = |said| by_window(said, &*plain, &log, long.length, &diagnosis.sigma);
            let (refitted, explained) = (errors(&refit)?, errors(&best)?);
            for (w, (refitted, explained)) in refitted.into_iter().zip(explained).enumerate() {
                let start = from + w * long.length;
                let rows = [start, (start + long.length).min(record.len())];
                windows.push(Window {
                    file: part.file.clone(),
                    rows: rows.map(|row| part.samples[0] + row),
                    refitted,
                    explained,
                    place: (index, rows),
                });
            }
        }
    }
    if windows.is_empty() {
        return Ok(None);
    }
    let middle = |of: fn(&Window) -> f64| median(&mut windows.iter().map(of).collect::<Vec<_>>());
    let (refitted, explained) = (middle(|w| w.refitted), middle(|w| w.explained));
    let rows = long.parts.iter().map(|(_, record)| record.len()).sum();
    let count = windows.len();
    let mut unlike: Vec<Window> =
        windows.into_iter().filter(|w| OTHER * explained.max(1.0) < w.explained).collect();
    unlike.sort_by(|a, b| b.explained.total_cmp(&a.explained));
    let unlike_count = unlike.len();
    unlike.truncate(MOST);
    let window = long.length;
    let whole =
        Whole { rows, fitted, window, windows: count, refitted, explained, unlike, unlike_count };
    Ok(Some(whole))
}

impl Whole {
    /// Windows that a fit should see as well: those of logs that are not held out.
    pub(super) fn to_fit<'a>(&'a self, long: &'a Long) -> impl Iterator<Item = &'a Window> {
        self.unlike.iter().filter(|window| long.parts[window.place.0].0.role == Role::Fit)
    }
}

/// Errors of forecasts, window by window, in units of the noise; infinite where a simulation diverges.
fn by_window(
    said: &Said,
    plain: &dyn Simulator,
    log: &Log,
    samples: usize,
    sigma: &[f64],
) -> Result<Vec<f64>, FitError> {
    let Some(errors) = said.errors(plain, log, Horizon::Windows { samples }, sigma)? else {
        return Ok(vec![f64::INFINITY; log.samples().div_ceil(samples)]);
    };
    let count = errors.first().map_or(0, Vec::len);
    let window = |w: usize| {
        let all = errors.iter().flat_map(|signals| signals[w].iter().copied());
        rms(all.filter(|error| error.is_finite()))
    };
    Ok((0..count).map(window).collect())
}
