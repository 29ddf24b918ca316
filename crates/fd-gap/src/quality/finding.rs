//! Things a user should know about a log before believing a diagnosis.

use std::fmt;

use fd_model::figure;
use schemars::JsonSchema;
use serde::Serialize;

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Severity {
    /// Good to know.
    Note,
    /// Answers suffer.
    Warning,
    /// The log cannot answer, or is not what it claims to be.
    Serious,
}

/// What was found.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Defect {
    /// The values lie on a grid that is coarse against the noise.
    Quantised {
        /// Distance of two neighbours on the grid, in the unit of the channel.
        step: f64,
    },
    /// Many values are exactly the largest or smallest one.
    Clipped {
        /// That value, in the unit of the channel.
        at: f64,
        /// Part of the samples that have it, 0 to 1.
        share: f64,
    },
    /// The channel does not change.
    Constant,
    /// The controller of the model makes the output of the other columns: it says nothing of the plant.
    Commanded,
    /// The output moves by no more than its noise.
    NotExcited,
    /// Samples are missing.
    Missing {
        /// Part of the samples, 0 to 1.
        share: f64,
    },
    /// The output moves too much from sample to sample for the dynamics to be seen.
    SlowSampling {
        /// Correlation of neighbouring samples, -1 to 1.
        correlation: f64,
    },
    /// An input answers what happened to the output by chance: a loop that the model does not have is
    /// closed over it.
    Feedback {
        /// Largest rank correlation of the unforeseen error with the unforeseen input, -1 to 1.
        correlation: f64,
        /// Name of the input.
        input: String,
    },
    /// One sample is wrong, and was left out.
    WrongSample {
        /// Number of the sample, from 0 at the start of the log.
        row: usize,
        /// What it reads, in the unit of the channel.
        found: f64,
        /// The smallest and the largest of its four neighbours, in that unit.
        around: [f64; 2],
    },
    /// The held-out log is the fitted one, or a part of it: it was not held out, and says nothing new.
    NotHeldOut,
    /// The channel fits the simulation better when multiplied.
    WrongUnit {
        /// By this power of ten, a pure number.
        factor: f64,
    },
    /// The log is shorter than the memory of the plant.
    Short {
        /// Length of the log, in seconds.
        seconds: f64,
        /// Slowest time constant of the plant, in seconds.
        memory: f64,
    },
    /// No input changes, and the output still moves when the model has come to rest: the log lacks what
    /// moved it.
    Undriven,
    /// The output does not respond to an input that the model says moves it: a drive that is off, braked or unplugged.
    Unresponsive {
        /// Name of the input.
        input: String,
    },
    /// An angle begins anew after a turn, and nothing says that it does.
    Wrapped {
        /// How often.
        times: usize,
    },
    /// The log begins in another state than the model says; the channel is that state.
    Elsewhere {
        /// Where it begins, in the unit of the state.
        start: f64,
        /// Where the model says, in that unit.
        stated: f64,
        /// Unit of the state.
        unit: String,
    },
    /// Two columns fit the simulation better when they are swapped.
    Swapped {
        /// The other one.
        with: String,
    },
}

/// What was found, and where.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Number of the log, from 1.
    pub log: usize,
    /// Name of the channel.
    pub channel: String,
    /// What was found.
    pub defect: Defect,
}

impl Finding {
    /// How bad it is.
    #[must_use]
    pub fn severity(&self) -> Severity {
        self.defect.severity()
    }
}

impl Defect {
    /// How bad it is.
    #[must_use]
    pub fn severity(&self) -> Severity {
        match self {
            Self::Quantised { .. }
            | Self::Missing { .. }
            | Self::Elsewhere { .. }
            | Self::Commanded => Severity::Note,
            Self::Clipped { .. }
            | Self::WrongSample { .. }
            | Self::NotHeldOut
            | Self::SlowSampling { .. }
            | Self::Feedback { .. }
            | Self::Short { .. }
            | Self::Constant => Severity::Warning,
            Self::NotExcited
            | Self::WrongUnit { .. }
            | Self::Undriven
            | Self::Unresponsive { .. }
            | Self::Wrapped { .. }
            | Self::Swapped { .. } => Severity::Serious,
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { log, channel, defect } = self;
        write!(f, "log {log}, `{channel}`: {defect}")
    }
}

impl fmt::Display for Defect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Quantised { step } => write!(f, "values are multiples of {}", figure(*step)),
            Self::Clipped { at, share } => {
                write!(f, "{:.0} % of the values are exactly {at}", 100.0 * share)
            }
            Self::Constant => write!(f, "the channel does not change"),
            Self::Commanded => write!(
                f,
                "the controller of the model computes this output from the other columns: it says nothing of the \
                 plant, and is left out"
            ),
            Self::NotExcited => {
                write!(
                    f,
                    "the output moves by no more than its noise: this log says nothing about it"
                )
            }
            Self::Missing { share } => write!(f, "{:.1} % is missing", 100.0 * share),
            Self::SlowSampling { correlation } => write!(
                f,
                "neighbouring samples have a correlation of only {correlation:.2}: the sampling is \
                 too slow for the dynamics"
            ),
            Self::Feedback { correlation, input } => write!(
                f,
                "the input `{input}` responds to the noise of this output (correlation {correlation:.2}): \
                 the log is from a loop that the model does not contain, and commands are taken as logged"
            ),
            Self::WrongSample { row, found, around: [low, high] } => write!(
                f,
                "sample {row} reads {found:.4}, its neighbours {low:.4} to {high:.4}: treated as a bad \
                 sample and left out"
            ),
            Self::Elsewhere { start, stated, unit } => write!(
                f,
                "the log begins with this state at {} {unit}, not at {} {unit} as the model says",
                figure(*start),
                figure(*stated)
            ),
            Self::NotHeldOut => write!(
                f,
                "this log is the fitted one, or a part of it: it was not held out, and is left out"
            ),
            Self::WrongUnit { factor } => write!(
                f,
                "multiplied by {factor} the channel would fit the simulation: check its unit"
            ),
            Self::Short { seconds, memory } => write!(
                f,
                "{seconds:.3} s is shorter than the memory of the plant ({memory:.3} s): slow dynamics \
                 cannot be told from the initial state. Or is a damping, a resistance or a time constant of the \
                 model in another unit?"
            ),
            Self::Undriven => write!(
                f,
                "the output moves, and no input does: the log lacks what moved it (a constant column \
                 in the place of an input?)"
            ),
            Self::Unresponsive { input } => write!(
                f,
                "the output does not respond to the input `{input}`: was the drive off, braked or unplugged, or the column \
                 of something else?"
            ),
            Self::Wrapped { times } => {
                let times = if *times == 1 { "once" } else { &format!("{times} times") };
                write!(
                    f,
                    "the angle jumps by a turn ({times}): if it begins anew after one, say `wraps = true` of this output in \
                     the model or the column map"
                )
            }
            Self::Swapped { with } => {
                write!(f, "the channel looks like `{with}`: two columns may be swapped")
            }
        }
    }
}
