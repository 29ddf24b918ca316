//! The request: what is to be diagnosed, and how.

use std::{
    fmt::{self, Display, Formatter},
    path::{Path, PathBuf},
    str::FromStr,
};

use fd_core::Limits;
use fd_effect::text::TextEffect;
use fd_gap::diagnose::ControllerSees;
use fd_log::{ColumnMap, Log, LogError, LogMap, LogTable, read_log};
use fd_model::{Channel, Disorder};
use schemars::JsonSchema;
use serde::{Serialize, Serializer};

use super::budget::Budget;

/// Most causes that are sought without another wish: forecasts end the road long before.
const MOST: usize = 8;

/// What is to be diagnosed.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Model file of the simulator.
    pub model: PathBuf,
    /// Logs of the real system.
    pub logs: Vec<PathBuf>,
    /// Logs in memory: a log that is called as one of them is that one, and no file.
    pub tables: Vec<LogTable>,
    /// Column map; channels that it does not name are found by their names.
    pub columns: Option<LogMap>,
    /// What is kept from all fits.
    pub held_out: HeldOutChoice,
    /// How long simulations run without seeing the outputs.
    pub horizon: HorizonChoice,
    /// Effects of one's own, which are tried with those of the library.
    pub effects: Vec<TextEffect>,
    /// Effects that are not tried: labels, families, or either at a site (`input-delay@u`).
    pub exclude: Vec<String>,
    /// The only effects that are tried, named alike; none means all.
    pub only: Vec<String>,
    /// Relative tolerances of parameters.
    pub tolerances: Vec<Named>,
    /// Standard deviations of the noise of outputs, in their units.
    pub noise: Vec<Named>,
    /// How uneven logs become even.
    pub resample: ResampleChoice,
    /// Most causes that are sought one after another, where one does not explain the logs; 1 for no more.
    pub most: usize,
    /// Whether the log is taken as it is read, without asking for wrong signs, units, columns and clocks.
    pub as_read: bool,
    /// Where logs begin.
    pub starts: StartsChoice,
    /// What a controller of the model acts on.
    pub controller_sees: ControllerSees,
    /// Seed of everything random.
    pub seed: u64,
    /// Replicas per cause of the self-calibration; none leaves it out.
    pub calibrate: Option<usize>,
    /// What a diagnosis of a simulator outside of this program may cost; none for what it needs.
    pub budget: Option<Budget>,
    /// Whether such a simulator is searched with as many runs as equations are, instead of few.
    pub thorough: bool,
    /// How large logs and the parts of the model may be.
    pub limits: Limits,
}

impl Request {
    /// A diagnosis with all defaults.
    ///
    /// ```
    /// use fdiag::gap_study::{HeldOutChoice, Request};
    ///
    /// let request = Request::new("cart.toml", ["monday.csv"]);
    /// assert_eq!(request.held_out, HeldOutChoice::Split(0.67));
    /// ```
    pub fn new<P: Into<PathBuf>>(
        model: impl Into<PathBuf>,
        logs: impl IntoIterator<Item = P>,
    ) -> Self {
        Self {
            model: model.into(),
            logs: logs.into_iter().map(Into::into).collect(),
            tables: Vec::new(),
            columns: None,
            held_out: HeldOutChoice::Split(0.67),
            horizon: HorizonChoice::Auto,
            effects: Vec::new(),
            exclude: Vec::new(),
            only: Vec::new(),
            tolerances: Vec::new(),
            noise: Vec::new(),
            resample: ResampleChoice::default(),
            most: MOST,
            as_read: false,
            starts: StartsChoice::default(),
            controller_sees: ControllerSees::default(),
            seed: 1,
            calibrate: None,
            budget: None,
            thorough: false,
            limits: Limits::default(),
        }
    }

    /// The column map, completed with the channels of a model: those that it does not name are found by their names, and those
    /// that have no unit there have that of the model.
    pub(super) fn map(&self, inputs: &[Channel], outputs: &[Channel]) -> LogMap {
        let mut map = self.columns.clone().unwrap_or_default();
        for (columns, channels) in [(&mut map.inputs, inputs), (&mut map.outputs, outputs)] {
            for channel in channels {
                match columns.iter_mut().find(|column| column.name == channel.name) {
                    Some(column) => {
                        column.unit.get_or_insert_with(|| channel.unit.clone());
                        column.wraps |= channel.wraps;
                    }
                    None => columns.push(ColumnMap::from(channel)),
                }
            }
        }
        map.resample.limits = self.limits;
        map
    }

    /// Reads a log, from memory if it is there.
    pub(super) fn read(&self, log: &Path, map: &LogMap) -> Result<Log, LogError> {
        match self.tables.iter().find(|table| Path::new(table.name()) == log) {
            Some(table) => table.read(map),
            None => read_log(log, map),
        }
    }
}

/// What is kept from all fits, to see how far the gap really shrinks.
#[derive(Clone, Debug, PartialEq)]
pub enum HeldOutChoice {
    /// Logs of their own.
    Logs(Vec<PathBuf>),
    /// The end of every log: this share of its samples, from the start, is fitted to.
    Split(f64),
}

/// How long a simulation runs without seeing the outputs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum HorizonChoice {
    /// Through the whole log, unless the model runs away from any start: then five times as long as it
    /// remembers what it does forget.
    #[default]
    Auto,
    /// Through the whole log.
    Free,
    /// For this many seconds.
    Seconds(f64),
}

impl FromStr for HorizonChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            "free" => Ok(Self::Free),
            seconds => match seconds.parse::<f64>() {
                Ok(seconds) if 0.0 < seconds && seconds.is_finite() => Ok(Self::Seconds(seconds)),
                _ => Err("expected `auto`, `free` or a number of seconds above 0".to_owned()),
            },
        }
    }
}

/// Where logs begin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StartsChoice {
    /// Where the model says, or anywhere: what explains the logs better.
    #[default]
    Either,
    /// Where the model says, within the tolerances of its initial states.
    Stated,
    /// Anywhere: initial states are unknowns.
    Free,
}

impl FromStr for StartsChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "either" => Ok(Self::Either),
            "stated" => Ok(Self::Stated),
            "free" => Ok(Self::Free),
            _ => Err("expected `either`, `stated` or `free`".to_owned()),
        }
    }
}

/// A value for something with a name: `NAME=VALUE`.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    /// The name.
    pub name: String,
    /// The value.
    pub value: f64,
}

impl Display for Named {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.name, self.value)
    }
}

/// As text, `NAME=VALUE`.
impl Serialize for Named {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl FromStr for Named {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, value) = text
            .split_once('=')
            .ok_or_else(|| "expected NAME=VALUE, such as mass=0.05".to_owned())?;
        match value.trim().parse::<f64>() {
            Ok(value) if value.is_finite() && 0.0 <= value => {
                Ok(Self { name: name.trim().to_owned(), value })
            }
            _ => Err(format!("expected a number from 0 on after `{name}=`, found `{value}`")),
        }
    }
}

/// How uneven logs become even; what is not stated here comes from the column map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ResampleChoice {
    /// Time between samples, in seconds.
    pub sample_time: Option<f64>,
    /// Longest hole that is bridged, in seconds.
    pub longest_gap: Option<f64>,
    /// What happens to samples that are not later than the one before.
    pub disorder: Disorder,
}
