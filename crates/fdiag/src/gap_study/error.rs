//! Errors that stop a gap diagnosis.

use std::path::PathBuf;

use crate::engine_plant::EngineFileError;
use fd_core::LimitError;
use fd_effect::text::TextError;
use fd_gap::fit::FitError;
use fd_log::LogError;
use fd_model::{ModelError, Shown, figure, file::ModelFileError};
use fd_sim::{model::LoadError, outside::OutsideError, simulate::SimulateError};
use thiserror::Error;

/// Logarithm of a factor by which two units are the same one.
const SAME_UNIT: f64 = 0.2;

/// A gap cannot be diagnosed.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum GapError {
    /// The model file is wrong, or a model that was changed as asked.
    #[error(transparent)]
    Model(Box<LoadError>),
    /// The file of a linear model is wrong.
    #[error(transparent)]
    Linear(Box<ModelFileError>),
    /// The model file of the engine is wrong.
    #[error(transparent)]
    Engine(Box<EngineFileError>),
    /// A simulator outside of this program cannot be used.
    #[error(transparent)]
    Simulator(Box<OutsideError>),
    /// A study failed after a simulator outside of this program was in trouble.
    #[error("{error}\nThe simulator was in trouble before: {trouble}")]
    Outside {
        /// Why the study failed.
        error: Box<GapError>,
        /// What had gone wrong last.
        trouble: Box<OutsideError>,
    },
    /// The model file is of a kind that cannot be diagnosed.
    #[error("{}: a model of kind `{}` cannot be diagnosed, expected {expected}", file.display(), Shown(found))]
    Kind {
        /// The file.
        file: PathBuf,
        /// Its `kind`.
        found: String,
        /// Kinds that can.
        expected: &'static str,
    },
    /// A setting names something that the model does not have.
    #[error("{option}: the model has no {what} `{}`, only {}", Shown(name), list(known))]
    Unknown {
        /// The option of the command line.
        option: &'static str,
        /// What was named.
        what: &'static str,
        /// The name.
        name: String,
        /// Names there are.
        known: Vec<String>,
    },
    /// A setting has a value that makes no sense.
    #[error("{option}: expected {expected}, found `{}`", Shown(found))]
    Setting {
        /// The option of the command line.
        option: &'static str,
        /// What would make sense.
        expected: &'static str,
        /// The value.
        found: String,
    },
    /// An effect of the request's own is wrong.
    #[error(transparent)]
    Effect(Box<TextError>),
    /// A part of the request is beyond a limit.
    #[error(transparent)]
    Limit(Box<LimitError>),
    /// The budget does not allow a diagnosis.
    #[error(
        "--budget: expected at least {needed} runs of the simulator through the logs, which take about {seconds} s; \
         found {found}"
    )]
    Budget {
        /// Runs that are needed.
        needed: u64,
        /// Their time, in seconds.
        seconds: String,
        /// What was allowed.
        found: String,
    },
    /// A log cannot be read.
    #[error(transparent)]
    Log(Box<LogError>),
    /// A log does not fit the model.
    #[error("{}: {source}", file.display())]
    Unfit {
        /// The log.
        file: PathBuf,
        /// Why not; logs are numbered in the order of the command line.
        source: Box<FitError>,
    },
    /// A channel has no value at all.
    #[error("{}: column of {role} `{channel}`: expected numbers, found none in {rows} rows", file.display())]
    Empty {
        /// The log.
        file: PathBuf,
        /// `input` or `output`.
        role: &'static str,
        /// Name of the channel.
        channel: String,
        /// Number of rows.
        rows: usize,
    },
    /// Samples come at another pace than the model says, by so much that a unit must be wrong.
    #[error(
        "{}: samples are {} s apart, the model says {} s: {}",
        file.display(), figure(*found), figure(*expected), other_time(column.as_deref(), found / expected)
    )]
    Pace {
        /// The log.
        file: PathBuf,
        /// The column that was taken for time; nothing where rows are counted.
        column: Option<String>,
        /// Sample time of the model, in seconds.
        expected: f64,
        /// Sample time of the log, in seconds.
        found: f64,
    },
    /// There is nothing to calibrate.
    #[error(
        "expected a parameter with a tolerance, found none: all parameters of the model are stated to be exact"
    )]
    NothingUncertain,
    /// The sample time is none.
    #[error("sample time: {0}")]
    SampleTime(Box<ModelError>),
    /// The model cannot be simulated.
    #[error("the model cannot be simulated: {0}")]
    Simulate(Box<SimulateError>),
    /// The model does not fit the logs.
    #[error(transparent)]
    Fit(Box<FitError>),
}

/// What is to be looked at where the pace is absurd: the column of time, or the sample time that was stated.
fn other_time(column: Option<&str>, times: f64) -> String {
    column.map_or("is `time.sample_time` of the column map right?".to_owned(), |column| {
        format!(
            "time was read from column `{}`: is it that column, and in seconds? State it in a column map \
             (`time = {{ column = \"...\", unit = \"{}\" }}`)",
            fd_model::Shown(column),
            time_unit(times)
        )
    })
}

/// The unit of a time column that makes samples so many times too far apart; milliseconds where none does.
fn time_unit(times: f64) -> &'static str {
    let units = [("ms", 1e3), ("us", 1e6), ("ns", 1e9), ("min", 1.0 / 60.0), ("h", 1.0 / 3600.0)];
    let off = |factor: f64| (times / factor).ln().abs();
    let near = units.into_iter().min_by(|a, b| off(a.1).total_cmp(&off(b.1)));
    near.filter(|(_, factor)| off(*factor) < SAME_UNIT).map_or("ms", |(name, _)| name)
}

/// Errors of the crates below are boxed, to keep results small.
macro_rules! boxed {
    ($($source:ty => $variant:ident),*) => {$(
        impl From<$source> for GapError {
            fn from(error: $source) -> Self {
                Self::$variant(Box::new(error))
            }
        }
    )*};
}

boxed!(LoadError => Model, ModelFileError => Linear, LogError => Log, FitError => Fit);
boxed!(EngineFileError => Engine, LimitError => Limit, OutsideError => Simulator);
boxed!(SimulateError => Simulate, ModelError => SampleTime, TextError => Effect);

fn list(names: &[String]) -> String {
    match names {
        [] => "none at all".to_owned(),
        names => format!("`{}`", names.join("`, `")),
    }
}
