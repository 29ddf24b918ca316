//! A clock that jitters: the error of a sample is what the output moves in the time by which the clock is off.
//!
//! Where the output stands still the noise is that of the sensor, where it runs it is more: a standard deviation of
//! `√(s² + τ² ẏ²)` at a slope `ẏ`, with the jitter `τ`. Taken for noise of one size, such errors have heavy tails.
//!
//! *When not to use:* where the slope hardly varies, or the noise is slow: then there is nothing to tell jitter by.

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

/// Log-likelihood that a jitter has to gain beyond its price: what a model lacks grows with the slope as well.
const RELUCTANT: f64 = 10.0;

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
        let pairs: Vec<(f64, f64)> = signals
            .iter()
            .flatten()
            .zip(slopes.iter().flatten())
            .filter(|(e, slope)| e.is_finite() && slope.is_finite())
            .map(|(e, slope)| (*e, *slope))
            .collect();
        let n = count(signals);
        let rms =
            |values: &mut dyn Iterator<Item = f64>| (values.map(|v| v * v).sum::<f64>() / n).sqrt();
        let size = rms(&mut pairs.iter().map(|(e, _)| *e));
        let steepness = rms(&mut pairs.iter().map(|(_, slope)| *slope));
        if !(0.0 < size && 0.0 < steepness && steepness.is_finite()) {
            return None;
        }
        let log = |s: f64, time: f64| -> f64 {
            let of = |(e, slope): &(f64, f64)| {
                let variance = s * s + (time * slope).powi(2);
                -0.5 * (e * e / variance + variance.ln() + (2.0 * PI).ln())
            };
            pairs.iter().map(of).sum::<f64>() - prior.cost(s.ln())
        };
        let level = |i: usize| size * LEAST.powf(i as f64 / (LEVELS - 1) as f64);
        let tried = TRIED
            .iter()
            .flat_map(|part| (0..LEVELS).map(move |i| (part * size / steepness, level(i))));
        let (best, time, s) =
            tried.map(|(time, s)| (log(s, time), time, s)).max_by(|a, b| a.0.total_cmp(&b.0))?;
        // Fisher's information of ln τ in a Gaussian of variance s² + τ² ẏ².
        let information: f64 = pairs
            .iter()
            .map(|(_, slope)| {
                let own = (time * slope).powi(2);
                2.0 * (own / (s * s + own)).powi(2)
            })
            .sum();
        let relative = information.max(1.0).sqrt().recip();
        let occam = 0.5 * (2.0 * PI).ln() + relative.ln() - DECADES.ln();
        let expected = prior.centre.exp();
        let calm = |(e, slope): (&f64, &f64)| e * expected / s.hypot(time * slope);
        let calm = |(signal, slopes): (&Vec<f64>, &Vec<f64>)| {
            signal.iter().zip(slopes).map(calm).collect()
        };
        let left: Vec<Vec<f64>> = signals.iter().zip(&slopes).map(calm).collect();
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
