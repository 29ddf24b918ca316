//! Test signals and noise: plain data with units and seeds, evaluated on an even time base.
//!
//! Every signal is a struct with public fields that can stand in a TOML file, and
//! [`SignalSpec`] is any one of them. Sample `k` is the value at `t = k·Ts`. Times are in
//! seconds, frequencies in Hz, phases in radians, amplitudes in the unit of the channel that the
//! signal drives. Random signals draw from `Xoshiro256PlusPlus` seeded by `seed`, so one seed
//! means the same numbers on every machine.
//!
//! ```
//! use fd_model::{SampleTime, signal::SignalSpec};
//!
//! let spec: SignalSpec = toml::from_str(
//!     r#"
//!     kind = "prbs"
//!     bits = 7
//!     clock_s = 0.2
//!     amplitude = 0.05
//!     seed = 3
//!     "#,
//! )?;
//! let u = spec.values(1000, SampleTime::new(0.1)?)?;
//! assert!(u.iter().all(|u| u.abs() == 0.05));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use serde::{Deserialize, Serialize};

use crate::domain::SampleTime;

mod check;
mod chirp;
mod error;
mod noise;
mod prbs;
mod sine;
mod staircase;
mod steps;

use self::sum::add;
pub use self::{
    chirp::{Chirp, Sweep},
    error::SignalError,
    noise::{ArNoise, WhiteNoise},
    prbs::Prbs,
    sine::{MultiSine, Phases},
    staircase::Staircase,
    steps::{Constant, Ramp, Step, StepSines},
};

/// Any signal, by the name of its `kind`.
///
/// An unknown kind or field is an error that lists the known ones:
///
/// ```
/// # use fd_model::signal::SignalSpec;
/// let error = toml::from_str::<SignalSpec>("kind = 'stair'").unwrap_err();
/// assert!(error.message().contains("`step`, `ramp`"), "{}", error.message());
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[non_exhaustive]
pub enum SignalSpec {
    /// The same value at all times.
    Constant(Constant),
    /// A jump.
    Step(Step),
    /// A straight rise.
    Ramp(Ramp),
    /// A sum of sinusoids.
    MultiSine(MultiSine),
    /// The paper's step plus multi-frequency sinusoid.
    StepSines(StepSines),
    /// A pseudo-random binary sequence.
    Prbs(Prbs),
    /// A swept sinusoid.
    Chirp(Chirp),
    /// Random levels held for random times.
    Staircase(Staircase),
    /// White Gaussian noise.
    WhiteNoise(WhiteNoise),
    /// Autoregressive Gaussian noise.
    ArNoise(ArNoise),
    /// A sum of signals.
    Sum {
        /// Signals that are added; none gives zero.
        terms: Vec<SignalSpec>,
    },
}

impl SignalSpec {
    /// The first `n` samples, at `t = 0, Ts, 2 Ts, …`.
    ///
    /// ```
    /// # use fd_model::{SampleTime, signal::{SignalSpec, Step}};
    /// let step = SignalSpec::from(Step::new(2.0, 0.1));
    /// assert_eq!(step.values(3, SampleTime::new(0.1)?)?, [0.0, 2.0, 2.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns the first parameter outside its range, or a frequency that the sample time cannot
    /// carry.
    pub fn values(&self, n: usize, ts: SampleTime) -> Result<Vec<f64>, SignalError> {
        match self {
            Self::Constant(signal) => signal.values(n),
            Self::Step(signal) => signal.values(n, ts),
            Self::Ramp(signal) => signal.values(n, ts),
            Self::MultiSine(signal) => signal.values(n, ts),
            Self::StepSines(signal) => signal.values(n, ts),
            Self::Prbs(signal) => signal.values(n, ts),
            Self::Chirp(signal) => signal.values(n, ts),
            Self::Staircase(signal) => signal.values(n, ts),
            Self::WhiteNoise(signal) => signal.values(n),
            Self::ArNoise(signal) => signal.values(n),
            Self::Sum { terms } => {
                terms.iter().try_fold(vec![0.0; n], |sum, term| Ok(add(sum, &term.values(n, ts)?)))
            }
        }
    }
}

macro_rules! from_signal {
    ($($signal:ident),* $(,)?) => {$(
        impl From<$signal> for SignalSpec {
            fn from(signal: $signal) -> Self {
                Self::$signal(signal)
            }
        }
    )*};
}

from_signal!(
    Constant, Step, Ramp, MultiSine, StepSines, Prbs, Chirp, Staircase, WhiteNoise, ArNoise
);

mod sum;
#[cfg(test)]
mod tests;
