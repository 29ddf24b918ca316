//! A mistake in the reading of a log or a model, and how it is undone.

use std::ops::Range;

use fd_model::{Record, SampleTime};
use fd_sim::model::Model;
use schemars::JsonSchema;
use serde::Serialize;

/// What is said of a column, of time or of a parameter, and is not so.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Mistake {
    /// Channels have the other sign.
    Sign {
        /// Their names.
        channels: Vec<String>,
    },
    /// Channels are in another unit.
    Unit {
        /// Their names.
        channels: Vec<String>,
        /// Logged value over real one.
        factor: f64,
    },
    /// A channel counts from another zero, as degrees Celsius do.
    Zero {
        /// Its name.
        channel: String,
        /// Logged value less real one, in the unit of the channel.
        offset: f64,
    },
    /// Values are cut off to a grid, downwards, instead of rounded: on average they are half a step too small.
    CutOff {
        /// Names of the outputs.
        channels: Vec<String>,
        /// Steps of their grids, in their units.
        steps: Vec<f64>,
    },
    /// Two columns stand for each other.
    Swap {
        /// Names of the channels.
        channels: [String; 2],
    },
    /// A channel has another clock than the others.
    Clock {
        /// Its name.
        channel: String,
        /// Samples by which it is logged late; early, where this is negative.
        late: i64,
    },
    /// Time is in another unit.
    Time {
        /// Time between samples of the log over the real one.
        factor: f64,
    },
    /// A parameter of the model has the other sign or is in another unit.
    Parameter {
        /// Its name.
        name: String,
        /// Stated value over real one; -1 for the sign.
        factor: f64,
    },
}

impl Mistake {
    /// The wrong sign of a channel.
    ///
    /// ```
    /// use fd_gap::reading::Mistake;
    /// use fd_model::{Channel, Record, SampleTime};
    ///
    /// let (u, y) = (vec![Channel::new("u", "V")], vec![Channel::new("y", "m")]);
    /// let log = Record::new(u, y, vec![1.0, 2.0], vec![0.0, 3.0], SampleTime::new(0.1)?)?;
    /// let mended = Mistake::sign("y").mended(&log).ok_or("a channel of that name")?;
    /// assert_eq!((mended.u(1), mended.y(1)), (&[2.0][..], &[-3.0][..]));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn sign(channel: &str) -> Self {
        Self::Sign { channels: vec![channel.to_owned()] }
    }

    /// The wrong unit of a channel; `factor` is the logged value over the real one.
    ///
    /// ```
    /// use fd_gap::reading::Mistake;
    /// use fd_model::{Channel, Record, SampleTime};
    ///
    /// let (u, y) = (vec![Channel::new("u", "V")], vec![Channel::new("y", "m")]);
    /// let log = Record::new(u, y, vec![1.0, 2.0], vec![0.0, 3.0], SampleTime::new(0.1)?)?;
    /// let mended = Mistake::unit("y", 100.0).mended(&log).ok_or("a channel of that name")?;
    /// assert_eq!(mended.y(1), [0.03]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn unit(channel: &str, factor: f64) -> Self {
        Self::Unit { channels: vec![channel.to_owned()], factor }
    }

    /// Names of the channels that are read wrongly; none where it is time or the model.
    #[must_use]
    pub fn channels(&self) -> Vec<&str> {
        match self {
            Self::Sign { channels }
            | Self::Unit { channels, .. }
            | Self::CutOff { channels, .. } => channels.iter().map(String::as_str).collect(),
            Self::Zero { channel, .. } | Self::Clock { channel, .. } => vec![channel],
            Self::Swap { channels } => channels.iter().map(String::as_str).collect(),
            Self::Time { .. } | Self::Parameter { .. } => Vec::new(),
        }
    }

    /// The record as it is really meant; `None` when it lacks a channel, or is too short.
    #[must_use]
    pub fn mended(&self, record: &Record) -> Option<Record> {
        let (inputs, outputs) = (record.inputs(), record.outputs());
        let nu = inputs.len();
        let place = |name: &str| {
            let output = || record.output_index(name).map(|i| nu + i);
            record.input_index(name).or_else(output)
        };
        let places = self.channels().into_iter().map(place).collect::<Option<Vec<usize>>>()?;
        let value = |k: usize, i: usize| if i < nu { record.u(k)[i] } else { record.y(k)[i - nu] };
        let late = match self {
            Self::Clock { late, .. } => isize::try_from(*late).ok()?,
            _ => 0,
        };
        let own = |k: usize, i: usize| {
            let Some(which) = places.iter().position(|place| *place == i) else {
                return value(k, i);
            };
            match self {
                Self::Sign { .. } => -value(k, i),
                Self::Unit { factor, .. } => value(k, i) / factor,
                Self::Zero { offset, .. } => value(k, i) - offset,
                Self::CutOff { steps, .. } => {
                    value(k, i) + 0.5 * steps.get(which).copied().unwrap_or_default()
                }
                Self::Swap { .. } => value(k, places[1 - which]),
                Self::Clock { .. } => value(k.saturating_add_signed(late), i),
                Self::Time { .. } | Self::Parameter { .. } => value(k, i),
            }
        };
        let rows = self.rows(record.len())?;
        let u = rows.clone().flat_map(|k| (0..nu).map(move |i| own(k, i)).collect::<Vec<_>>());
        let u: Vec<f64> = u.collect();
        let all = nu + outputs.len();
        let y = rows.clone().flat_map(|k| (nu..all).map(|i| own(k, i)).collect::<Vec<_>>());
        let y: Vec<f64> = y.collect();
        let scale = match self {
            Self::Time { factor } => *factor,
            _ => 1.0,
        };
        let ts = SampleTime::new(record.ts().seconds() / scale).ok()?;
        let start = record.time(rows.start) / scale;
        let mended = Record::new(inputs.to_vec(), outputs.to_vec(), u, y, ts).ok()?;
        Some(mended.at_the_place_of(record).starting_at(start))
    }

    /// The rows of a log of `n` samples in which all channels have a value of the same time.
    fn rows(&self, n: usize) -> Option<Range<usize>> {
        let Self::Clock { late, .. } = self else { return Some(0..n) };
        let lost = usize::try_from(late.unsigned_abs()).ok().filter(|lost| 2 * lost < n)?;
        Some(if 0 < *late { 0..n - lost } else { lost..n })
    }

    /// The model as it is really meant: the same one, unless a parameter is wrong; `None` when that
    /// makes no valid model.
    #[must_use]
    pub fn mended_model(&self, model: &Model) -> Option<Model> {
        let Self::Parameter { name, factor } = self else { return Some(model.clone()) };
        let mut draft = model.clone().into_draft();
        let parameter = draft.parameters.iter_mut().find(|p| p.name == *name)?;
        parameter.value /= factor;
        // What was said of the value was said in the wrong unit, too.
        parameter.bounds = parameter.bounds.map(|[a, b]| {
            let (a, b) = (a / factor, b / factor);
            [a.min(b), a.max(b)]
        });
        Model::try_from(draft).ok()
    }

    /// Logged value over real one of a channel.
    pub(super) fn scale(&self, channel: &str) -> f64 {
        match self {
            Self::Unit { channels, factor } if channels.iter().any(|c| c == channel) => {
                factor.abs()
            }
            _ => 1.0,
        }
    }

    /// The channel whose column really belongs to `channel`.
    pub(super) fn column<'a>(&'a self, channel: &'a str) -> &'a str {
        match self {
            Self::Swap { channels: [a, b] } if a == channel => b,
            Self::Swap { channels: [a, b] } if b == channel => a,
            _ => channel,
        }
    }
}
