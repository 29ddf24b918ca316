//! What can go wrong with an engine.

use std::fmt;

use fd_model::ModelError;
use thiserror::Error;

/// A compressor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compressor {
    /// Low-pressure compressor; its surge indicator is the relative flow `x`, which must stay
    /// above the peak of the characteristic.
    LowPressure,
    /// High-pressure compressor; its surge indicator is the relative loading `y`, which must
    /// stay below the surge loading.
    HighPressure,
}

impl fmt::Display for Compressor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::LowPressure => "low-pressure compressor (relative flow x too low)",
            Self::HighPressure => "high-pressure compressor (loading y too high)",
        })
    }
}

/// An engine cannot be built, trimmed or run.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum EngineError {
    /// A compressor left its stable range; the model does not describe what follows.
    #[error("surge of the {compressor} at {time} s: indicator {value}, limit {limit}")]
    Surge {
        /// Which compressor.
        compressor: Compressor,
        /// Its surge indicator (`x` or `y`, pure numbers).
        value: f64,
        /// Limit of the indicator.
        limit: f64,
        /// Time since the start of the run, s.
        time: f64,
    },
    /// A state is not a positive finite number.
    #[error("state {index} of the engine is {value} at {time} s")]
    NonFinite {
        /// Index of the state, from 0.
        index: usize,
        /// Its value.
        value: f64,
        /// Time since the start of the run, s.
        time: f64,
    },
    /// The equilibrium was not found.
    #[error(
        "no equilibrium at a fuel flow of {fuel} kg/s after {iterations} iterations: \
         largest relative rate {residual} /s"
    )]
    NoTrim {
        /// Fuel flow, kg/s.
        fuel: f64,
        /// Newton iterations spent.
        iterations: usize,
        /// Largest `|ẋ_i / x_i|` left, 1/s.
        residual: f64,
    },
    /// A derived constant of the design is not that of an engine.
    #[error("the reference point gives {quantity} = {value}, which must be positive")]
    Design {
        /// What was derived.
        quantity: &'static str,
        /// Its value.
        value: f64,
    },
    /// A quantity that must lie in a range does not.
    #[error("{quantity} must be in {low}..={high} {unit}, got {value}")]
    OutOfRange {
        /// Which quantity.
        quantity: &'static str,
        /// Its value.
        value: f64,
        /// Lowest value.
        low: f64,
        /// Highest value.
        high: f64,
        /// Unit.
        unit: &'static str,
    },
    /// The values about which a linear model holds are needed, but not published.
    #[error("the operating point of this linear engine is not known")]
    NoOperatingPoint,
    /// A perturbation of physical parameters was asked of a linear model.
    #[error("this perturbation needs the nonlinear engine: a linear model has no parameters")]
    NotPhysical,
    /// All perturbed engines were unstable.
    #[error("none of {draws} perturbed engines was stable")]
    NoStableEngine {
        /// Engines that were drawn.
        draws: usize,
    },
    /// A linear model cannot be built.
    #[error(transparent)]
    Model(#[from] ModelError),
}
