//! Sinusoids whose frequency sweeps over a band.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use crate::{
    domain::SampleTime,
    signal::{
        check::{below_nyquist, finite, in_range, positive_seconds, times},
        error::SignalError,
    },
};

/// `amplitude · sin(2π ∫ f dt + phase)`, where `f` goes from `from_hz` to `to_hz` in
/// `duration_s` and stays there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chirp {
    /// Amplitude, in the unit of the channel.
    pub amplitude: f64,
    /// Frequency at `t = 0`, in Hz.
    pub from_hz: f64,
    /// Frequency from `duration_s` on, in Hz; may be below `from_hz`.
    pub to_hz: f64,
    /// Length of the sweep, in seconds.
    pub duration_s: f64,
    /// How the frequency moves.
    #[serde(default)]
    pub sweep: Sweep,
    /// Phase at `t = 0`, in radians.
    #[serde(default)]
    pub phase_rad: f64,
}

/// How the frequency of a [`Chirp`] moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Sweep {
    /// By the same number of hertz each second.
    #[default]
    Linear,
    /// By the same factor each second.
    Exponential,
}

impl Chirp {
    /// A linear sweep between two frequencies in Hz, over `duration_s` seconds.
    ///
    /// ```
    /// # use fd_model::{SampleTime, signal::{Chirp, Sweep}};
    /// let mut chirp = Chirp::new(1.0, 0.1, 2.0, 60.0);
    /// chirp.sweep = Sweep::Exponential;
    /// let u = chirp.values(600, SampleTime::new(0.1)?)?;
    /// assert!(u.iter().all(|u| u.abs() <= 1.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn new(amplitude: f64, from_hz: f64, to_hz: f64, duration_s: f64) -> Self {
        Self { amplitude, from_hz, to_hz, duration_s, sweep: Sweep::Linear, phase_rad: 0.0 }
    }

    /// The first `n` samples.
    ///
    /// # Errors
    ///
    /// Returns the first parameter outside its range, or a frequency at or above half the sample
    /// rate.
    pub fn values(&self, n: usize, ts: SampleTime) -> Result<Vec<f64>, SignalError> {
        finite("chirp", "amplitude", self.amplitude)?;
        finite("chirp", "phase_rad", self.phase_rad)?;
        positive_seconds("chirp", "duration_s", self.duration_s)?;
        for (parameter, f) in [("from_hz", self.from_hz), ("to_hz", self.to_hz)] {
            in_range("chirp", parameter, "above 0 Hz", f, 0.0 < f)?;
            below_nyquist("chirp", f, ts)?;
        }
        Ok(times(n, ts)
            .map(|t| self.amplitude * (TAU * self.turns(t) + self.phase_rad).sin())
            .collect())
    }

    /// `∫₀ᵗ f dt`, in turns.
    fn turns(&self, t: f64) -> f64 {
        let swept = t.min(self.duration_s);
        let octaves = (self.to_hz / self.from_hz).ln();
        let turns = match self.sweep {
            // f = from (to/from)^(t/T); exp_m1 keeps the limit of equal frequencies exact.
            Sweep::Exponential if octaves != 0.0 => {
                self.from_hz * self.duration_s / octaves
                    * (octaves * swept / self.duration_s).exp_m1()
            }
            Sweep::Linear | Sweep::Exponential => {
                let rate = (self.to_hz - self.from_hz) / self.duration_s;
                (self.from_hz + 0.5 * rate * swept) * swept
            }
        };
        turns + self.to_hz * (t - swept)
    }
}
