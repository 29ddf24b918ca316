//! Which of several settled models forecasts best, and how sure that is.

use crate::together::each;
use fd_compensate::calibrate::autocorrelation_time;
use fd_sim::simulate::Simulator;

use super::{
    forecast::{Forecast, Settled, forecast},
    gap::{BLOCK, Closed, closed},
};
use crate::{
    evidence::{BlockErrors, win_frequencies_over},
    fit::{FitError, Horizon, Log},
};

/// A block is at most this part of the logs, or there would be too few.
const FEWEST_BLOCKS: usize = 8;
/// Pieces of a block: blocks begin at any of them.
const PIECES: usize = 4;

/// How a contest is run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
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

/// What settled models forecast of sets of logs, at several horizons.
#[derive(Clone, Debug)]
pub struct Forecasts {
    /// Sets that have logs, usually those of the fit and those held out.
    sets: Vec<OfSet>,
    outputs: usize,
}

#[derive(Clone, Debug)]
struct OfSet {
    /// Samples of each log.
    samples: Vec<usize>,
    /// Per model and horizon.
    each: Vec<Vec<Option<Forecast>>>,
}

impl Forecasts {
    /// Lets models forecast at these horizons, with noise of `sigma` in each output, in its unit; the first model is the one
    /// without any effect. Sets without logs do not count.
    ///
    /// # Errors
    ///
    /// As [`forecast_errors`](super::forecast_errors).
    pub fn of(
        nominal: &dyn Simulator,
        contenders: &[Settled<'_>],
        sets: &[&[Log]],
        horizons: &[Horizon],
        sigma: &[f64],
    ) -> Result<Self, FitError> {
        let of_set = |logs: &&[Log]| {
            let of = |contender: &Settled<'_>| {
                let each = horizons.iter();
                each.map(|h| forecast(nominal, *contender, logs, *h, sigma)).collect()
            };
            let each = each(contenders, of).into_iter().collect::<Result<_, _>>()?;
            Ok(OfSet { samples: logs.iter().map(Log::samples).collect(), each })
        };
        let sets = sets.iter().filter(|logs| !logs.is_empty()).map(of_set);
        Ok(Self { sets: sets.collect::<Result<_, FitError>>()?, outputs: nominal.outputs().len() })
    }

    /// The same beside what is known later: all errors move as far as those of the model at the place `from` are from those
    /// at the place `to` of what was forecast `later` of the same logs. Exact where effects add up; no run is needed.
    #[must_use]
    pub fn beside(&self, from: usize, later: &Self, to: usize) -> Self {
        let mut moved = self.clone();
        for (set, later) in moved.sets.iter_mut().zip(&later.sets) {
            for (h, target) in later.each[to].iter().enumerate() {
                let (Some(target), Some(known)) = (target, set.each[from][h].clone()) else {
                    continue;
                };
                for forecast in set.each.iter_mut().filter_map(|all| all[h].as_mut()) {
                    forecast.moved(&known, target);
                }
            }
        }
        moved
    }

    /// Who wins, by the mean over sets, horizons and outputs of the logarithm of the error, under a moving-block bootstrap
    /// ([`win_frequencies_over`]): what fits a little better and forecasts much worse loses, and where the two disagree
    /// there is one winner all the same.
    #[must_use]
    pub fn contest(&self, rules: &Rules) -> Contest {
        let tables: Vec<_> = self.sets.iter().map(|set| set.tables(self.outputs)).collect();
        let tables: Vec<Vec<&BlockErrors>> =
            tables.iter().map(|set| set.iter().map(Vec::as_slice).collect()).collect();
        let tables: Vec<&[&BlockErrors]> = tables.iter().map(Vec::as_slice).collect();
        let wins = win_frequencies_over(&tables, PIECES, rules.replicas, rules.seed);
        let closed = self.sets.last().map_or_else(Vec::new, |set| set.shares(rules));
        Contest { wins, closed }
    }
}

impl Forecast {
    /// Its errors, as far from where they were as `to` is from `from`.
    fn moved(&mut self, from: &Self, to: &Self) {
        let from = from.errors.iter().flatten();
        let signals = from.zip(to.errors.iter().flatten());
        for (own, (from, to)) in self.errors.iter_mut().flatten().zip(signals) {
            for (own, (from, to)) in own.iter_mut().zip(from.iter().zip(to)) {
                *own += to - from;
            }
        }
    }
}

impl OfSet {
    /// Errors in pieces of blocks: per horizon and output, per contender.
    fn tables(&self, outputs: usize) -> Vec<Vec<Vec<[f64; 2]>>> {
        let Some(first) = self.each.first() else { return Vec::new() };
        let length = block_length(first, self.samples.iter().sum());
        let cells = Cells::new(&self.samples, length.div_ceil(PIECES));
        let mut tables = Vec::new();
        for h in 0..first.len() {
            for output in 0..outputs {
                let of = |all: &Vec<Option<Forecast>>| cells.sums(all[h].as_ref(), output);
                tables.push(self.each.iter().map(of).collect());
            }
        }
        tables
    }

    /// The shares of the gap of the first contender that each one closes.
    fn shares(&self, rules: &Rules) -> Vec<Vec<Option<Closed>>> {
        let share = |(before, after): (&Option<Forecast>, &Option<Forecast>)| {
            let (before, after) = (&before.as_ref()?.errors, &after.as_ref()?.errors);
            closed(before, after, rules.floor, rules.replicas, rules.seed)
        };
        let of = |all: &Vec<Option<Forecast>>| self.each[0].iter().zip(all).map(share).collect();
        each(&self.each, of)
    }
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
    fn new(samples: &[usize], length: usize) -> Self {
        let mut count = 0;
        let first = samples.iter().map(|samples| {
            let first = count;
            count += samples.div_ceil(length);
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
