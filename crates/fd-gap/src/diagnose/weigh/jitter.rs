//! A clock that jitters: the error of a sample is what the output moves in the time by which the clock is off.
//!
//! Where the output stands still the noise is that of the sensor, where it runs it is more: a standard deviation of
//! `√(s² + τ² ẏ²)` at a slope `ẏ`, with the jitter `τ`. Taken for noise of one size, such errors have heavy tails.
//!
//! The noise may have a colour, the jitter has none: what is left of a first-order autoregression and a white error of
//! known variance is told by a scalar Kalman filter.
//!
//! *When not to use:* where the slope hardly varies: then there is nothing to tell jitter by.

use std::f64::consts::PI;

use super::{
    gaussian::{count, gaussian},
    known::slopes,
    stronger_noise::{Known, WHITE},
};
use crate::{
    evidence::{DECADES, NoisePrior},
    fit::Problem,
    quality::Autoregression,
};

/// Jitters that are tried, of the one that would explain all errors by itself.
const TRIED: [f64; 12] = [0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0];
/// Noise levels that are tried with each, of the size of all errors.
const LEVELS: usize = 40;
/// Smallest level.
const LEAST: f64 = 0.02;
/// Coefficients of the noise, a first-order autoregression, that are tried.
const COLOURS: [f64; 7] = [0.0, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95];

/// Log-likelihood that a jitter has to gain beyond its price: what a model lacks grows with the slope as well.
const RELUCTANT: f64 = 10.0;

/// Noise and a jitter.
#[derive(Clone, Copy, Debug)]
struct Tried {
    /// Standard deviation of the noise, in sigma.
    noise: f64,
    /// That of the clock, in seconds.
    time: f64,
    /// Coefficient of the autoregression of the noise.
    colour: f64,
}

/// An error as it is foretold by those before it; NaN where nothing was measured.
#[derive(Clone, Copy, Debug)]
struct Foretold {
    error: f64,
    variance: f64,
}

impl Foretold {
    fn log(&self) -> f64 {
        let Self { error, variance } = *self;
        if error.is_finite() {
            -0.5 * (error * error / variance + variance.ln() + (2.0 * PI).ln())
        } else {
            0.0
        }
    }
}

impl Tried {
    /// The errors of a run, each as far as those before it do not foretell it (a scalar Kalman filter).
    fn foretold<'a>(
        self,
        (errors, slopes): (&'a [f64], &'a [f64]),
    ) -> impl Iterator<Item = Foretold> + 'a {
        let Self { noise, time, colour } = self;
        let (mut mean, mut variance) = (0.0, noise * noise);
        errors.iter().zip(slopes).map(move |(e, slope)| {
            let own = (time * slope).powi(2);
            let is_known = is_known(&(e, slope));
            let total = if is_known { variance + own } else { variance };
            let error = if is_known { e - mean } else { f64::NAN };
            if is_known {
                let gain = variance / total;
                mean += gain * error;
                variance -= gain * variance;
            }
            mean *= colour;
            variance = colour * colour * variance + (1.0 - colour * colour) * noise * noise;
            Foretold { error, variance: total }
        })
    }
}

fn is_known((e, slope): &(&f64, &f64)) -> bool {
    e.is_finite() && slope.is_finite()
}

/// What a jittering clock makes of the errors of an output.
#[derive(Clone, Debug)]
pub(super) struct Jitter {
    /// Logarithm of the evidence over that of noise of one size.
    pub(super) gain: f64,
    /// Standard deviation of the clock, in seconds.
    pub(super) time: Known,
    /// The errors with the jitter taken out: those of a clock that runs evenly.
    pub(super) left: Vec<Vec<f64>>,
}

impl Jitter {
    /// Weighs a jitter by the errors of an output (in sigma), of which `outputs` are the simulated values.
    pub(super) fn of(
        signals: &[Vec<f64>],
        prior: NoisePrior,
        problem: &Problem,
        outputs: &[Vec<f64>],
        output: usize,
    ) -> Option<Self> {
        let slopes = slopes(problem, outputs, output);
        let runs: Vec<(&[f64], &[f64])> =
            signals.iter().map(Vec::as_slice).zip(slopes.iter().map(Vec::as_slice)).collect();
        let pairs = || runs.iter().flat_map(|(e, slopes)| e.iter().zip(*slopes)).filter(is_known);
        let n = count(signals);
        let rms = |sum: f64| (sum / n).sqrt();
        let size = rms(pairs().map(|(e, _)| e * e).sum());
        let steepness = rms(pairs().map(|(_, slope)| slope * slope).sum());
        if !(0.0 < size && 0.0 < steepness && steepness.is_finite()) {
            return None;
        }
        let log = |tried: &Tried| -> f64 {
            let log: f64 =
                runs.iter().map(|run| tried.foretold(*run).map(|f| f.log()).sum::<f64>()).sum();
            // A colour costs what any of its coefficients does.
            let price = if tried.colour == 0.0 { 0.0 } else { 0.5 * n.ln() };
            log - prior.cost(tried.noise.ln()) - price
        };
        let colours = if prior.is_coloured { &COLOURS[..] } else { &COLOURS[..1] };
        let level = |i: usize| size * LEAST.powf(i as f64 / (LEVELS - 1) as f64);
        let tried = colours.iter().flat_map(|colour| {
            TRIED.iter().flat_map(move |part| {
                let time = part * size / steepness;
                (0..LEVELS).map(move |i| Tried { noise: level(i), time, colour: *colour })
            })
        });
        let (best, tried) =
            tried.map(|tried| (log(&tried), tried)).max_by(|a, b| a.0.total_cmp(&b.0))?;
        let Tried { noise: s, time, .. } = tried;
        // Fisher's information of ln τ in a Gaussian of variance s² + τ² ẏ².
        let information: f64 = pairs()
            .map(|(_, slope)| {
                let own = (time * slope).powi(2);
                2.0 * (own / (s * s + own)).powi(2)
            })
            .sum();
        let relative = information.max(1.0).sqrt().recip();
        let occam = 0.5 * (2.0 * PI).ln() + relative.ln() - DECADES.ln();
        let expected = prior.centre.exp();
        let calm = |run: &(&[f64], &[f64])| {
            tried.foretold(*run).map(|f| f.error * expected / f.variance.sqrt()).collect()
        };
        let left: Vec<Vec<f64>> = runs.iter().map(calm).collect();
        // A lag is wrong by the slope as well, but always the same way; a clock is late and early by chance.
        let even: Vec<&[f64]> = left.iter().map(Vec::as_slice).collect();
        if Autoregression::fit(&even, Autoregression::HIGHEST_ORDER).innovation() < WHITE {
            return None;
        }
        Some(Self {
            gain: best - gaussian(signals, prior).log + occam - RELUCTANT,
            time: Known { value: time, standard_error: time * relative },
            left,
        })
    }
}
