//! The clock of a unit: from samples at the times they have to samples on an even time base, one by one.
//!
//! It does what [`fd_model::ResamplePolicy`] does to a log: on a grid time that meets a sample the sample is taken as it
//! is; elsewhere inputs keep the value of the sample before and outputs are interpolated between the samples before and
//! after. What a log may not have (a clock that goes back, a time that is far ahead and wrong) is left out, and told.

use serde::{Deserialize, Serialize};

use crate::{bits, input::Runs, message::What};

/// What a clock goes by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ClockPlan {
    /// Step of the grid, in s.
    pub step: f64,
    /// Longest distance of samples that is bridged, in s.
    pub longest_gap: f64,
    /// Distance from a grid time that counts as none, in steps.
    pub tolerance: f64,
    /// Inputs are the first so many values.
    pub inputs: usize,
}

/// What comes of a sample.
pub(crate) enum Tick<'a> {
    /// A sample on the grid.
    Sample {
        /// Its time in s.
        time: f64,
        /// Inputs, then outputs.
        values: &'a [f64],
    },
    /// The next sample on the grid does not follow the last one.
    Anew,
    /// Something to be told, with the time in s of the sample that it is about.
    Told(f64, What),
}

/// A sample as it arrived.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Raw {
    #[serde(with = "bits::one")]
    time: f64,
    #[serde(with = "bits::many")]
    values: Vec<f64>,
}

/// The memory of a clock.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Clock {
    last: Option<Raw>,
    /// Far ahead of `last`, until another sample confirms it.
    pending: Option<Raw>,
    #[serde(with = "bits::one")]
    start: f64,
    /// Samples on the grid since `start`.
    taken: u64,
    /// Samples that were left out in a row, and why.
    #[serde(skip)]
    left_out: Option<(Left, Runs)>,
    #[serde(skip)]
    bridged: Runs,
    /// After a restart: samples left out because they are not news.
    #[serde(skip)]
    resuming: Option<u64>,
    #[serde(skip)]
    between: Vec<f64>,
    /// Samples left out since somebody asked, those that are no surprise after a restart not counted.
    #[serde(skip)]
    pub dropped: u64,
}

/// Why a sample is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Left {
    Doubled,
    Late,
    Backwards,
}

impl Clock {
    /// After a restart, samples that are not newer than the last are no surprise.
    pub(crate) fn resume(&mut self) {
        self.resuming = Some(0);
    }

    /// Whether the numbers can be the memory of a clock.
    pub(crate) fn is_sound(&self, channels: usize) -> bool {
        let raw = |raw: &Option<Raw>| {
            raw.as_ref().is_none_or(|raw| raw.time.is_finite() && raw.values.len() == channels)
        };
        raw(&self.last) && raw(&self.pending) && self.start.is_finite() && self.taken < 1 << 53
    }

    /// Takes a sample.
    pub(crate) fn take(
        &mut self,
        plan: &ClockPlan,
        time: f64,
        values: &[f64],
        told: &mut dyn FnMut(Tick<'_>),
    ) {
        let newest = match (&self.last, &self.pending) {
            (Some(last), _) => last.time,
            (None, Some(pending)) => pending.time,
            (None, None) => {
                self.news(time, told);
                self.pending = Some(Raw { time, values: values.to_vec() });
                return;
            }
        };
        let is_pending = self.pending.as_ref().is_some_and(|p| same(p.time, time));
        // Without a last sample a first one that was wrong must not keep all others out.
        if same(newest, time) || is_pending || (time < newest && self.last.is_some()) {
            let doubled = same(newest, time) || is_pending;
            self.leave_out(plan, doubled, newest, time, told);
            return;
        }
        self.news(time, told);
        match (&self.last, self.pending.take()) {
            (Some(last), pending) if time - last.time <= plan.longest_gap => {
                if let Some(pending) = pending {
                    self.dropped += 1;
                    told(Tick::Told(time, What::ClockJumped { to: pending.time }));
                }
                self.accept(plan, time, values, told);
            }
            (last, Some(pending))
                if pending.time < time && time - pending.time <= plan.longest_gap =>
            {
                if let Some(last) = last {
                    told(Tick::Told(time, What::Gap { from: last.time, to: pending.time }));
                }
                told(Tick::Anew);
                (self.start, self.taken) = (pending.time, 1);
                told(Tick::Sample { time: pending.time, values: &pending.values });
                self.last = Some(pending);
                self.accept(plan, time, values, told);
            }
            (_, pending) => {
                if let Some(pending) = pending {
                    self.dropped += 1;
                    told(Tick::Told(time, What::ClockJumped { to: pending.time }));
                }
                self.pending = Some(Raw { time, values: values.to_vec() });
            }
        }
    }

    /// Samples on the grid up to one that follows the last one.
    fn accept(
        &mut self,
        plan: &ClockPlan,
        time: f64,
        values: &[f64],
        told: &mut dyn FnMut(Tick<'_>),
    ) {
        let Some(last) = &mut self.last else { return };
        let (length, before) = (time - last.time, last.time);
        let tolerance = plan.tolerance * plan.step;
        loop {
            let grid = self.start + self.taken as f64 * plan.step;
            if time + tolerance < grid {
                break;
            }
            self.taken += 1;
            if (grid - time).abs() <= tolerance {
                told(Tick::Sample { time: grid, values });
                continue;
            }
            let share = (grid - before) / length;
            self.between.clear();
            let pairs = last.values.iter().zip(values);
            self.between.extend(pairs.enumerate().map(|(i, (&old, &new))| {
                if i < plan.inputs { old } else { old + share * (new - old) }
            }));
            told(Tick::Sample { time: grid, values: &self.between });
        }
        last.time = time;
        last.values.clear();
        last.values.extend_from_slice(values);
        let bridge = |count, ended| What::Bridged { from: before, to: time, count, ended };
        if 1.5 * plan.step < length {
            if let Some(count) = self.bridged.more() {
                told(Tick::Told(time, bridge(count, false)));
            }
        } else if let Some(count) = self.bridged.end() {
            told(Tick::Told(time, bridge(count, true)));
        }
    }

    fn leave_out(
        &mut self,
        plan: &ClockPlan,
        doubled: bool,
        newest: f64,
        time: f64,
        told: &mut dyn FnMut(Tick<'_>),
    ) {
        if let Some(seen) = &mut self.resuming {
            *seen += 1;
            return;
        }
        self.dropped += 1;
        let left = match () {
            () if doubled => Left::Doubled,
            () if newest - time <= plan.longest_gap => Left::Late,
            () => Left::Backwards,
        };
        if self.left_out.is_some_and(|(before, _)| before != left) {
            self.end_of_left_out(time, told);
        }
        let (_, runs) = self.left_out.get_or_insert((left, Runs::default()));
        if let Some(count) = runs.more() {
            told(Tick::Told(time, left.what(count, false, newest)));
        }
    }

    /// A sample that is newer than all before.
    fn news(&mut self, time: f64, told: &mut dyn FnMut(Tick<'_>)) {
        if let Some(seen) = self.resuming.take().filter(|seen| 0 < *seen) {
            told(Tick::Told(time, What::Resumed { seen }));
        }
        self.end_of_left_out(time, told);
    }

    fn end_of_left_out(&mut self, time: f64, told: &mut dyn FnMut(Tick<'_>)) {
        if let Some((left, mut runs)) = self.left_out.take()
            && let Some(count) = runs.end()
        {
            let newest = self.last.as_ref().or(self.pending.as_ref()).map_or(time, |raw| raw.time);
            told(Tick::Told(time, left.what(count, true, newest)));
        }
    }
}

impl Left {
    fn what(self, count: u64, ended: bool, newest: f64) -> What {
        match self {
            Self::Doubled => What::Doubled { count, ended },
            Self::Late => What::Late { count, ended, newest },
            Self::Backwards => What::ClockBackwards { count, ended, newest },
        }
    }
}

/// The same time, to the bit but for the sign of zero.
fn same(a: f64, b: f64) -> bool {
    a.total_cmp(&b).is_eq() || (a - b).abs() <= 0.0
}
