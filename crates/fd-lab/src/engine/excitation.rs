//! Inputs of the benchmark runs: steps combined with multi-frequency sinusoids.

use std::f64::consts::{PI, TAU};

use fd_model::{Channel, Inputs, ModelError, SampleTime};
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};

/// The training input: a level from the first sample on, steps, and a fixed set of tones.
///
/// The steps matter: with one step only, parameters that the tones do not excite are left to the
/// noise, and the next step that comes shows it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TrainingRun {
    /// Duration in s.
    pub duration_s: f64,
    /// Level from the first sample on, per unit.
    pub level: f64,
    /// Further steps: time in s and height per unit.
    pub steps: Vec<(f64, f64)>,
    /// Number of tones.
    pub tones: usize,
    /// Lowest and highest tone in rad/s; the tones are spaced evenly in the logarithm.
    pub tone_band_rad_s: (f64, f64),
    /// Amplitude of each tone, per unit.
    pub tone_amplitude: f64,
}

impl Default for TrainingRun {
    fn default() -> Self {
        Self {
            duration_s: 60.0,
            level: 0.1,
            steps: vec![(12.0, -0.134), (24.0, 0.116), (36.0, -0.093), (48.0, 0.1)],
            tones: 12,
            tone_band_rad_s: (0.21, 11.7),
            tone_amplitude: 0.0129,
        }
    }
}

/// A fresh input: level, one step and tones drawn anew for every run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FreshRun {
    /// Duration in s.
    pub duration_s: f64,
    /// Level at the first sample, per unit: ±(0.5 … 1.5) times this.
    pub level: f64,
    /// One more step at 20 to 80 % of the run, per unit: −1 … 1 times this.
    pub step: f64,
    /// Number of tones.
    pub tones: usize,
    /// Band in rad/s that the tones are drawn from, evenly in the logarithm.
    pub tone_band_rad_s: (f64, f64),
    /// Amplitude of each tone, per unit: 0.5 … 1.5 times this.
    pub tone_amplitude: f64,
}

impl Default for FreshRun {
    fn default() -> Self {
        Self {
            duration_s: 30.0,
            level: 0.1,
            step: 0.1,
            tones: 5,
            tone_band_rad_s: (0.3, 9.0),
            tone_amplitude: 0.02,
        }
    }
}

impl TrainingRun {
    /// The input on every channel. With several channels the steps of one fall between those of
    /// the others and the tones have other phases, so that the channels can be told apart.
    ///
    /// # Errors
    ///
    /// Returns an error when there are no channels.
    pub fn inputs(&self, channels: &[Channel], ts: SampleTime) -> Result<Inputs, ModelError> {
        let nu = channels.len();
        let gap = self.duration_s / ((self.steps.len() + 1) * nu.max(1)) as f64;
        sampled(channels, self.duration_s, ts, |t, channel| {
            let delay = gap * channel as f64;
            let start = if t >= delay { self.level } else { 0.0 };
            let steps: f64 =
                self.steps.iter().filter(|(at, _)| t >= at + delay).map(|(_, height)| height).sum();
            let tones: f64 = (0..self.tones)
                .map(|i| {
                    let share = i as f64 / (self.tones.max(2) - 1) as f64;
                    let omega = geometric(self.tone_band_rad_s, share);
                    // Schroeder's phases keep the peaks of the sum low.
                    let square = (i * i) as f64;
                    let phase = PI * square / self.tones as f64 + TAU * (i * channel) as f64 / 3.0;
                    self.tone_amplitude * (omega * t + phase).sin()
                })
                .sum();
            start + steps + tones
        })
    }
}

impl FreshRun {
    /// An input drawn from `rng` on every channel.
    ///
    /// # Errors
    ///
    /// Returns an error when there are no channels.
    pub fn inputs(
        &self,
        channels: &[Channel],
        ts: SampleTime,
        rng: &mut Xoshiro256PlusPlus,
    ) -> Result<Inputs, ModelError> {
        let draws: Vec<Draw> = channels.iter().map(|_| self.draw(rng)).collect();
        sampled(channels, self.duration_s, ts, |t, channel| draws[channel].at(t))
    }

    /// One input of any length on every channel, without jumps but for the steps of a run: every `duration_s` a
    /// step and other tones, as in a run drawn anew, but from the level where the last ended, and the tones change
    /// gradually. The level stays where fresh runs have it: below the sum of `level` and `step`.
    ///
    /// # Errors
    ///
    /// Returns an error when there are no channels.
    pub fn long_inputs(
        &self,
        channels: &[Channel],
        ts: SampleTime,
        samples: usize,
        rng: &mut Xoshiro256PlusPlus,
    ) -> Result<Inputs, ModelError> {
        let stretch = (self.duration_s / ts.seconds()).round().max(1.0);
        let count = whole((samples as f64 / stretch).ceil()).max(1);
        let fade = FADE_S.min(0.5 * self.duration_s);
        let highest = self.level.abs() + self.step.abs();
        let draws: Vec<Vec<Draw>> = channels
            .iter()
            .map(|_| {
                let mut level = None;
                (0..count)
                    .map(|_| {
                        let mut draw = self.draw(rng);
                        draw.level = level.unwrap_or(draw.level);
                        // A step that would leave the range of fresh runs goes the other way.
                        if (draw.level + draw.step).abs() > highest {
                            draw.step = -draw.step;
                        }
                        level = Some(draw.level + draw.step);
                        draw
                    })
                    .collect()
            })
            .collect();
        let duration = samples as f64 * ts.seconds();
        sampled(channels, duration, ts, |t, channel| {
            let at = whole(t / self.duration_s).min(count - 1);
            let (draw, since) = (&draws[channel][at], t - at as f64 * self.duration_s);
            let mut tones = draw.tones_at(t);
            if at > 0 && since < fade {
                let before = draws[channel][at - 1].tones_at(t);
                tones = before + (tones - before) * since / fade;
            }
            draw.level_at(since) + tones
        })
    }

    fn draw(&self, rng: &mut Xoshiro256PlusPlus) -> Draw {
        let sign = if rng.random::<bool>() { 1.0 } else { -1.0 };
        let level = sign * self.level * rng.random_range(0.5..1.5);
        let step_at = self.duration_s * rng.random_range(0.2..0.8);
        let step = self.step * rng.random_range(-1.0..1.0);
        let tones = (0..self.tones)
            .map(|_| {
                let omega = geometric(self.tone_band_rad_s, rng.random_range(0.0..1.0));
                let amplitude = self.tone_amplitude * rng.random_range(0.5..1.5);
                (omega, amplitude, rng.random_range(0.0..TAU))
            })
            .collect();
        Draw { level, step_at, step, tones }
    }
}

/// How long one set of tones takes to become the next, in s.
const FADE_S: f64 = 5.0;

struct Draw {
    level: f64,
    step_at: f64,
    step: f64,
    tones: Vec<(f64, f64, f64)>,
}

impl Draw {
    fn at(&self, t: f64) -> f64 {
        self.level_at(t) + self.tones_at(t)
    }

    fn level_at(&self, t: f64) -> f64 {
        self.level + if t >= self.step_at { self.step } else { 0.0 }
    }

    fn tones_at(&self, t: f64) -> f64 {
        self.tones.iter().map(|(w, a, phase)| a * (w * t + phase).sin()).sum()
    }
}

fn geometric((low, high): (f64, f64), share: f64) -> f64 {
    low * (high / low).powf(share)
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small count")]
fn whole(count: f64) -> usize {
    count.max(0.0) as usize
}

fn sampled(
    channels: &[Channel],
    duration_s: f64,
    ts: SampleTime,
    f: impl Fn(f64, usize) -> f64,
) -> Result<Inputs, ModelError> {
    let samples = whole((duration_s / ts.seconds()).round());
    let u = (0..samples)
        .flat_map(|k| (0..channels.len()).map(move |channel| (k, channel)))
        // Every run begins at rest, so that filters and models can begin there too.
        .map(|(k, channel)| if k == 0 { 0.0 } else { f(k as f64 * ts.seconds(), channel) })
        .collect();
    Inputs::new(channels.to_vec(), u, samples, ts)
}
