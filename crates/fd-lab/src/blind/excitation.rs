//! What drives a plant during a test run.

use serde::{Deserialize, Serialize};

use super::random::Random;

/// The shape of an excitation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// Two levels, switched at random multiples of a clock.
    Prbs,
    /// Eight sinusoids of random phase.
    Multisine,
    /// A swept sinusoid.
    Chirp,
    /// Random levels for random times.
    Steps,
    /// Up and down in equal steps.
    Staircase,
    /// Low-pass filtered noise.
    SlowRandom,
}

impl Shape {
    /// All shapes.
    pub const ALL: [Self; 6] =
        [Self::Prbs, Self::Multisine, Self::Chirp, Self::Steps, Self::Staircase, Self::SlowRandom];
}

/// Range and band of the excitation of one external input.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drive {
    pub centre: f64,
    pub amplitude: f64,
    /// Lowest and highest frequency, in Hz.
    pub band: [f64; 2],
}

impl Drive {
    /// The values of all samples.
    pub(super) fn signal(&self, shape: Shape, samples: usize, ts: f64, seed: u64) -> Vec<f64> {
        let random = &mut Random::new(seed);
        let signal = match shape {
            Shape::Prbs => self.prbs(samples, ts, random),
            Shape::Multisine => self.multisine(samples, ts, random),
            Shape::Chirp => self.chirp(samples, ts, random),
            Shape::Steps => self.steps(samples, ts, random),
            Shape::Staircase => self.staircase(samples, ts, random),
            Shape::SlowRandom => self.slow_random(samples, ts, random),
        };
        let peak = signal.iter().fold(1e-12_f64, |peak, s| peak.max(s.abs()));
        let size = random.uniform(0.7, 1.0) * self.amplitude / peak;
        signal.into_iter().map(|s| self.centre + size * s).collect()
    }

    fn middle(&self) -> f64 {
        (self.band[0] * self.band[1]).sqrt()
    }

    fn prbs(&self, samples: usize, ts: f64, random: &mut Random) -> Vec<f64> {
        let clock = count(1.0 / (2.0 * self.band[1] * ts));
        let mut level = random.sign();
        (0..samples)
            .map(|k| {
                if k % clock == 0 {
                    level = random.sign();
                }
                level
            })
            .collect()
    }

    fn multisine(&self, samples: usize, ts: f64, random: &mut Random) -> Vec<f64> {
        let [low, high] = self.band;
        let tones: Vec<(f64, f64)> = (0..8)
            .map(|i| {
                let f = low * (high / low).powf((f64::from(i) + random.unit()) / 8.0);
                (std::f64::consts::TAU * f * ts, random.uniform(0.0, 6.3))
            })
            .collect();
        (0..samples)
            .map(|k| tones.iter().map(|(w, phase)| (w * k as f64 + phase).sin()).sum())
            .collect()
    }

    fn chirp(&self, samples: usize, ts: f64, random: &mut Random) -> Vec<f64> {
        let [low, high] = self.band;
        let (mut phase, start) = (random.uniform(0.0, 6.3), random.uniform(0.0, 0.3));
        (0..samples)
            .map(|k| {
                let place = (k as f64 / samples as f64 + start) % 1.0;
                phase += std::f64::consts::TAU * ts * low * (high / low).powf(place);
                phase.sin()
            })
            .collect()
    }

    fn steps(&self, samples: usize, ts: f64, random: &mut Random) -> Vec<f64> {
        let (mut level, mut left) = (0.0, 0);
        (0..samples)
            .map(|_| {
                if left == 0 {
                    level = random.uniform(-1.0, 1.0);
                    left = count(random.uniform(0.3, 1.2) / (self.middle() * ts));
                }
                left -= 1;
                level
            })
            .collect()
    }

    fn staircase(&self, samples: usize, ts: f64, random: &mut Random) -> Vec<f64> {
        let step = count(random.uniform(0.2, 0.5) / (self.middle() * ts));
        let (stairs, sign) = (3 + random.below(4), random.sign());
        (0..samples)
            .map(|k| {
                // A triangle in whole steps, first up, then down.
                let place = (k / step + stairs / 2) % (2 * stairs);
                let height = place.min(2 * stairs - place) as f64 / stairs as f64;
                sign * (2.0 * height - 1.0)
            })
            .collect()
    }

    fn slow_random(&self, samples: usize, ts: f64, random: &mut Random) -> Vec<f64> {
        let pole = (-std::f64::consts::TAU * self.middle() * ts).exp();
        let mut states = [0.0; 2];
        (0..samples)
            .map(|_| {
                states[0] = pole * states[0] + (1.0 - pole) * random.normal();
                states[1] = pole * states[1] + (1.0 - pole) * states[0];
                states[1]
            })
            .collect()
    }
}

/// A number of samples, at least one.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small and positive")]
fn count(samples: f64) -> usize {
    samples.round().max(1.0) as usize
}
