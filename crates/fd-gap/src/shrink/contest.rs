//! Which of several settled models forecasts best, and how sure that is.

use fd_compensate::calibrate::autocorrelation_time;
use fd_sim::simulate::Simulator;
use rayon::prelude::*;

use super::{
    forecast::{Forecast, Settled, forecast},
    gap::{Closed, closed},
};
use crate::{
    evidence::{BlockErrors, win_frequencies_over},
    fit::{FitError, Horizon, Log},
};

/// Length of a bootstrap block, in autocorrelation times of the errors without any effect.
const BLOCK: f64 = 5.0;
/// A block is at most this part of the logs, or there would be too few.
const FEWEST_BLOCKS: usize = 8;
/// Pieces of a block: blocks begin at any of them.
const PIECES: usize = 4;

/// How a contest is run.
#[derive(Clone, Debug, PartialEq)]
pub struct Rules<'a> {
    /// Horizons.
    pub horizons: &'a [Horizon],
    /// Noise of each output, in its unit.
    pub sigma: &'a [f64],
    /// Noise floor, in sigma.
    pub floor: f64,
    /// Replicas of the bootstrap.
    pub replicas: usize,
    /// Seed of the bootstrap.
    pub seed: u64,
}

/// The outcome of a contest on some logs.
#[derive(Clone, Debug, PartialEq)]
pub struct Contest {
    /// Shares of replicas that each contender wins.
    pub wins: Vec<f64>,
    /// Per contender and horizon, the share of the reducible gap of the first contender that is
    /// closed in the last set of logs; `None` where a simulation diverges, or there is no gap.
    pub closed: Vec<Vec<Option<Closed>>>,
}

/// Lets settled models forecast sets of logs at several horizons: usually those of the fit, and those held out. The first
/// model is the one without any effect. Wins go by the mean over sets, horizons and outputs of the logarithm of the error,
/// under a moving-block bootstrap ([`win_frequencies_over`]): what fits a little better and forecasts much worse
/// loses, and where the two disagree there is one winner all the same. Sets without logs do not count.
///
/// # Errors
///
/// As [`forecast_errors`](super::forecast_errors).
pub fn contest(
    nominal: &dyn Simulator,
    contenders: &[Settled<'_>],
    sets: &[&[Log]],
    rules: &Rules<'_>,
) -> Result<Contest, FitError> {
    let sets = || sets.iter().filter(|logs| !logs.is_empty());
    let all = sets().map(|logs| forecasts(nominal, contenders, logs, rules));
    let all: Vec<Vec<Forecasts>> = all.collect::<Result<_, _>>()?;
    let outputs = nominal.outputs().len();
    let tables: Vec<Vec<Vec<Vec<[f64; 2]>>>> =
        all.iter().zip(sets()).map(|(of_set, logs)| tables(of_set, logs, outputs)).collect();
    let tables: Vec<Vec<&BlockErrors>> =
        tables.iter().map(|set| set.iter().map(Vec::as_slice).collect()).collect();
    let tables: Vec<&[&BlockErrors]> = tables.iter().map(Vec::as_slice).collect();
    let wins = win_frequencies_over(&tables, PIECES, rules.replicas, rules.seed);
    let closed = all.last().map_or_else(Vec::new, |forecasts| shares(forecasts, rules));
    Ok(Contest { wins, closed })
}

/// Forecasts of one contender, horizon by horizon.
type Forecasts = Vec<Option<Forecast>>;

/// What all contenders forecast.
fn forecasts(
    nominal: &dyn Simulator,
    contenders: &[Settled<'_>],
    logs: &[Log],
    rules: &Rules<'_>,
) -> Result<Vec<Forecasts>, FitError> {
    let of = |contender: &Settled<'_>| {
        let each = rules.horizons.iter();
        each.map(|h| forecast(nominal, *contender, logs, *h, rules.sigma)).collect()
    };
    contenders.par_iter().map(of).collect()
}

/// Errors in pieces of blocks: per horizon and output, per contender.
fn tables(forecasts: &[Forecasts], logs: &[Log], outputs: usize) -> Vec<Vec<Vec<[f64; 2]>>> {
    let Some(first) = forecasts.first() else { return Vec::new() };
    let samples: usize = logs.iter().map(Log::samples).sum();
    let cells = Cells::new(logs, block_length(first, samples).div_ceil(PIECES));
    let mut tables = Vec::new();
    for h in 0..first.len() {
        for output in 0..outputs {
            let of = |all: &Forecasts| cells.sums(all[h].as_ref(), output);
            tables.push(forecasts.iter().map(of).collect());
        }
    }
    tables
}

/// The shares of the gap of the first contender that each one closes.
fn shares(forecasts: &[Forecasts], rules: &Rules<'_>) -> Vec<Vec<Option<Closed>>> {
    let share = |(before, after): (&Option<Forecast>, &Option<Forecast>)| {
        let (before, after) = (&before.as_ref()?.errors, &after.as_ref()?.errors);
        closed(before, after, rules.floor, rules.replicas, rules.seed)
    };
    let of = |all: &Forecasts| forecasts[0].iter().zip(all).map(share).collect();
    forecasts.par_iter().map(of).collect()
}

/// Five autocorrelation times of the errors without any effect, at the longest horizon.
fn block_length(forecasts: &[Option<Forecast>], samples: usize) -> usize {
    let most = (samples / FEWEST_BLOCKS).max(1);
    let memory = |signals: &Vec<Vec<f64>>| {
        let signal: Vec<f64> =
            signals.iter().flatten().copied().filter(|v| v.is_finite()).collect();
        autocorrelation_time(&signal)
    };
    let Some(errors) = forecasts.iter().flatten().next_back().map(|f| &f.errors) else {
        return most;
    };
    let times = errors.iter().map(memory).collect::<Option<Vec<f64>>>();
    let Some(times) = times else { return most };
    let length = BLOCK * times.into_iter().fold(1.0, f64::max);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at least 5")]
    let length = length.ceil() as usize;
    length.min(most)
}

/// Logs cut into pieces of equal length, but for the last one of each.
struct Cells {
    /// Number of the first piece of each log.
    first: Vec<usize>,
    length: usize,
    count: usize,
}

impl Cells {
    fn new(logs: &[Log], length: usize) -> Self {
        let mut count = 0;
        let first = logs.iter().map(|log| {
            let first = count;
            count += log.samples().div_ceil(length);
            first
        });
        Self { first: first.collect(), length, count }
    }

    /// Sums of squares and numbers of the errors of one output.
    fn sums(&self, forecast: Option<&Forecast>, output: usize) -> Vec<[f64; 2]> {
        let Some(forecast) = forecast else { return vec![[f64::INFINITY, 1.0]; self.count] };
        let mut sums = vec![[0.0; 2]; self.count];
        for (signal, segment) in forecast.errors[output].iter().zip(&forecast.segments) {
            for (i, error) in signal.iter().enumerate().filter(|(_, error)| error.is_finite()) {
                let cell = &mut sums[self.first[segment.log] + (segment.from + i) / self.length];
                cell[0] += error * error;
                cell[1] += 1.0;
            }
        }
        sums
    }
}
