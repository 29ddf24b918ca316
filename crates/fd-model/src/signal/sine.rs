//! Sums of sinusoids with given, random or Schroeder phases.

use std::f64::consts::{PI, TAU};

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};

use crate::{
    domain::SampleTime,
    signal::{
        check::{below_nyquist, finite, in_range, times},
        error::SignalError,
        sum::add,
    },
};

/// `Σ aᵢ sin(2π fᵢ t + φᵢ)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MultiSine {
    /// Frequencies `fᵢ`, in Hz, each above zero and below half the sample rate.
    pub frequencies_hz: Vec<f64>,
    /// Amplitudes `aᵢ`, in the unit of the channel, one per frequency.
    pub amplitudes: Vec<f64>,
    /// Phases `φᵢ`.
    #[serde(default)]
    pub phases: Phases,
}

/// How the phases of a [`MultiSine`] are chosen.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
#[non_exhaustive]
pub enum Phases {
    /// All zero: each sinusoid starts at zero and rises.
    #[default]
    Zero,
    /// As given.
    Given {
        /// Phases in radians, one per frequency.
        rad: Vec<f64>,
    },
    /// Uniform over the circle.
    Random {
        /// Seed of the draw.
        seed: u64,
    },
    /// `φᵢ = −2π Σ_{l<i} (i − l) pₗ` with the share `pₗ` of the power in line `l`, which keeps
    /// the peaks low (Schroeder 1970). For equal amplitudes this is `−π i (i − 1) / N`.
    Schroeder,
}

impl MultiSine {
    /// Sinusoids with the given frequencies in Hz and amplitudes.
    ///
    /// ```
    /// # use fd_model::{SampleTime, signal::{MultiSine, Phases}};
    /// let sine = MultiSine::new(vec![0.25], vec![2.0], Phases::Zero);
    /// assert_eq!(sine.values(2, SampleTime::new(1.0)?)?, [0.0, 2.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn new(frequencies_hz: Vec<f64>, amplitudes: Vec<f64>, phases: Phases) -> Self {
        Self { frequencies_hz, amplitudes, phases }
    }

    /// Sinusoids of one amplitude at multiples of a fundamental frequency in Hz.
    ///
    /// ```
    /// # use fd_model::signal::{MultiSine, Phases};
    /// let odd = MultiSine::harmonics(0.1, &[1, 3, 5], 1.0, Phases::Schroeder);
    /// assert_eq!(odd.frequencies_hz.len(), 3);
    /// ```
    #[must_use]
    pub fn harmonics(
        fundamental_hz: f64,
        multiples: &[u32],
        amplitude: f64,
        phases: Phases,
    ) -> Self {
        let frequencies_hz = multiples.iter().map(|&m| f64::from(m) * fundamental_hz).collect();
        Self { frequencies_hz, amplitudes: vec![amplitude; multiples.len()], phases }
    }

    /// The first `n` samples.
    ///
    /// # Errors
    ///
    /// Returns an error when the lists differ in length, a number is not finite, or a frequency
    /// is not between zero and half the sample rate.
    pub fn values(&self, n: usize, ts: SampleTime) -> Result<Vec<f64>, SignalError> {
        self.check(ts)?;
        let lines = self.frequencies_hz.iter().zip(&self.amplitudes).zip(self.phases_rad());
        Ok(lines.fold(vec![0.0; n], |sum, ((&f, &a), phase)| {
            let line: Vec<f64> = times(n, ts).map(|t| a * (TAU * f * t + phase).sin()).collect();
            add(sum, &line)
        }))
    }

    /// The phases in radians, one per frequency.
    ///
    /// ```
    /// # use fd_model::signal::{MultiSine, Phases};
    /// let sines = MultiSine::harmonics(1.0, &[1, 2], 1.0, Phases::Schroeder);
    /// assert_eq!(sines.phases_rad(), [0.0, -std::f64::consts::PI]);
    /// ```
    #[must_use]
    pub fn phases_rad(&self) -> Vec<f64> {
        let n = self.frequencies_hz.len();
        match &self.phases {
            Phases::Zero => vec![0.0; n],
            Phases::Given { rad } => rad.clone(),
            Phases::Random { seed } => {
                let mut rng = Xoshiro256PlusPlus::seed_from_u64(*seed);
                (0..n).map(|_| TAU * rng.random::<f64>()).collect()
            }
            Phases::Schroeder => self.schroeder(),
        }
    }

    fn schroeder(&self) -> Vec<f64> {
        let power: f64 = self.amplitudes.iter().map(|a| a * a).sum();
        if power <= 0.0 {
            return vec![0.0; self.amplitudes.len()];
        }
        // The double sum is the running sum of the running sum of the shares.
        let (mut share, mut phase) = (0.0, 0.0);
        self.amplitudes
            .iter()
            .map(|a| {
                let this = phase;
                share += a * a / power;
                phase -= 2.0 * PI * share;
                this
            })
            .collect()
    }

    fn check(&self, ts: SampleTime) -> Result<(), SignalError> {
        const SIGNAL: &str = "multi-sine";
        let expected = self.frequencies_hz.len();
        let mut lists = vec![("amplitudes", &self.amplitudes)];
        if let Phases::Given { rad } = &self.phases {
            lists.push(("phases", rad));
        }
        for (parameter, values) in lists {
            if values.len() != expected {
                let found = values.len();
                return Err(SignalError::Lengths { signal: SIGNAL, parameter, expected, found });
            }
            values.iter().try_for_each(|&value| finite(SIGNAL, parameter, value))?;
        }
        self.frequencies_hz.iter().try_for_each(|&f| {
            in_range(SIGNAL, "frequencies_hz", "above 0 Hz", f, 0.0 < f)?;
            below_nyquist(SIGNAL, f, ts)
        })
    }
}
