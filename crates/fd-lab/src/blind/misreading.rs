//! Mistakes in the reading of a log: what is said of its columns is not what is in them.
//!
//! Clocks are shifted so that an answer comes before its question (a command is logged late, an
//! output early): the other way round it would be a delay, and no log could tell.

use fd_model::Record;
use fd_sim::model::Model;
use serde::{Deserialize, Serialize};

use super::random::Random;

/// A mistake in the reading of a log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Misreading {
    /// The wrong sign of a channel.
    Sign {
        /// Name of the channel.
        channel: String,
    },
    /// The wrong unit of a channel.
    Unit {
        /// Name of the channel.
        channel: String,
        /// Logged value over real one.
        factor: f64,
    },
    /// Two columns for each other.
    Swap {
        /// Names of the channels.
        channels: [String; 2],
    },
    /// The wrong clock of a channel.
    Clock {
        /// Name of the channel.
        channel: String,
        /// By how many samples it is logged late; early, where it is negative.
        late: i64,
    },
    /// The wrong unit of time.
    Time {
        /// Real time between samples over what the log says.
        factor: usize,
    },
}

/// Samples by which a clock is off.
const SHIFTS: [f64; 2] = [2.0, 20.0];

impl Misreading {
    /// Name of its kind.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Sign { .. } => "sign",
            Self::Unit { .. } => "unit",
            Self::Swap { .. } => "swap",
            Self::Clock { .. } => "clock",
            Self::Time { .. } => "time",
        }
    }

    /// The channels that are read wrongly; none where it is time.
    #[must_use]
    pub fn channels(&self) -> Vec<&str> {
        match self {
            Self::Sign { channel } | Self::Unit { channel, .. } | Self::Clock { channel, .. } => {
                vec![channel]
            }
            Self::Swap { channels } => channels.iter().map(String::as_str).collect(),
            Self::Time { .. } => vec![],
        }
    }

    /// Any mistake that can be made with the channels of a model.
    pub(super) fn draw(model: &Model, random: &mut Random) -> Self {
        let (inputs, outputs) = (model.external_inputs(), model.output_channels());
        let all = [&inputs[..], &outputs[..]].concat();
        let any = all[random.below(all.len())].clone();
        let lists = [&inputs, &outputs];
        let twos: Vec<_> = lists.into_iter().filter(|list| 1 < list.len()).collect();
        match random.below(if twos.is_empty() { 5 } else { 6 }) {
            0 => Self::Sign { channel: any.name },
            // Units are what is taken wrongly most often.
            1 | 2 => {
                let factors = factors(&any.unit);
                Self::Unit { factor: factors[random.below(factors.len())], channel: any.name }
            }
            3 => {
                #[expect(clippy::cast_possible_truncation, reason = "small")]
                let late = random.log_uniform(SHIFTS[0], SHIFTS[1]).round() as i64;
                let is_input = inputs.contains(&any);
                Self::Clock { channel: any.name, late: if is_input { late } else { -late } }
            }
            4 => Self::Time { factor: if random.sign() < 0.0 { 10 } else { 60 } },
            _ => {
                let list = twos[random.below(twos.len())];
                let first = random.below(list.len());
                let second = (first + 1 + random.below(list.len() - 1)) % list.len();
                Self::Swap { channels: [first, second].map(|i| list[i].name.clone()) }
            }
        }
    }

    /// Samples that a run needs beyond those of the log, before and after it.
    pub(super) fn margin(&self) -> usize {
        match self {
            Self::Clock { late, .. } => usize::try_from(late.unsigned_abs()).unwrap_or(0),
            _ => 0,
        }
    }

    /// The log as it is read; the margin at both ends is lost.
    pub(super) fn read(&self, log: &Record) -> Result<Record, fd_model::ModelError> {
        let (inputs, outputs, n) = (log.inputs(), log.outputs(), log.len());
        let margin = self.margin();
        let names: Vec<&str> =
            inputs.iter().chain(outputs).map(|channel| channel.name.as_str()).collect();
        let place = |name: &str| names.iter().position(|known| *known == name);
        let value = |k: usize, i: usize| {
            if i < inputs.len() { log.u(k)[i] } else { log.y(k)[i - inputs.len()] }
        };
        let own = |k: usize, i: usize| match self {
            Self::Sign { channel } if place(channel) == Some(i) => -value(k, i),
            Self::Unit { channel, factor } if place(channel) == Some(i) => factor * value(k, i),
            Self::Clock { channel, late } if place(channel) == Some(i) => {
                value(k.saturating_add_signed(isize::try_from(-late).unwrap_or(0)), i)
            }
            Self::Swap { channels: [a, b] } => {
                let (a, b) = (place(a), place(b));
                let from = if Some(i) == a {
                    b
                } else if Some(i) == b {
                    a
                } else {
                    None
                };
                value(k, from.unwrap_or(i))
            }
            _ => value(k, i),
        };
        let rows = margin..n - margin;
        let (nu, all) = (inputs.len(), names.len());
        let u = rows.clone().flat_map(|k| (0..nu).map(move |i| own(k, i)));
        let y = rows.flat_map(|k| (nu..all).map(move |i| own(k, i)));
        let (inputs, outputs) = (inputs.to_vec(), outputs.to_vec());
        let read = Record::new(inputs, outputs, u.collect(), y.collect(), log.ts())?;
        Ok(read.starting_at(log.time(0)))
    }
}

/// Factors that a unit is taken wrongly by.
fn factors(unit: &str) -> Vec<f64> {
    let degrees = 180.0 / std::f64::consts::PI;
    let per_minute = 30.0 / std::f64::consts::PI;
    match unit {
        "rad" => vec![degrees, 1.0 / degrees],
        "rad/s" => vec![degrees, 1.0 / degrees, per_minute, 1.0 / per_minute],
        "N" | "N m" | "m/s^2" => vec![9.81, 1.0 / 9.81, 1e3, 1e-3],
        "V" | "A" | "m" | "m^3/s" => vec![1e3, 1e-3],
        _ => vec![1e2, 1e-2],
    }
}
