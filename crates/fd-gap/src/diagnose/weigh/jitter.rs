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
    colour::COLOURED,
    gaussian::{count, gaussian},
    known::slopes,
    stronger_noise::Known,
};
use crate::{
    evidence::{DECADES, NoisePrior, best_log_scale, grades::BEYOND_DOUBT},
    fit::Problem,
    quality::Autoregression,
};

/// Places that are tried of the share that a jitter has in the errors, and of the colour of the noise.
const PLACES: usize = 40;

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
    pub gain: f64,
    /// Standard deviation of the clock, in seconds.
    pub time: Known,
    /// The errors with the jitter taken out: those of a clock that runs evenly.
    pub left: Vec<Vec<f64>>,
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
        // With the noise as the unit everything is foretold as well, so that its best size is known at once.
        let sized = |unit: Tried| -> (f64, Tried) {
            let (mut squares, mut spreads) = (0.0, 0.0);
            for found in runs.iter().flat_map(|run| unit.foretold(*run)) {
                if found.error.is_finite() {
                    squares += found.error * found.error / found.variance;
                    spreads += found.variance.ln();
                }
            }
            let size = best_log_scale(n, squares, &prior);
            let misfit = squares * (-2.0 * size).exp();
            let noise = size.exp();
            let log = -0.5 * (misfit + spreads + 2.0 * n * size + n * (2.0 * PI).ln());
            // A colour costs what any of its coefficients does.
            let price = if unit.colour == 0.0 { 0.0 } else { 0.5 * n.ln() };
            let tried = Tried { noise, time: noise * unit.time, colour: unit.colour };
            (log - prior.cost(size) - price, tried)
        };
        let part = |i: usize| i as f64 / PLACES as f64;
        let colours = if prior.is_coloured { PLACES } else { 1 };
        let tried = (0..colours).flat_map(|colour| {
            (1..PLACES).map(move |i| {
                // The share is the squared sine of angles that are evenly apart: as evenly as shares can be told apart
                // (Jeffreys).
                let time = (0.5 * PI * part(i)).tan() / steepness;
                Tried { noise: 1.0, time, colour: part(colour) }
            })
        });
        let (best, tried) = tried.map(sized).max_by(|a, b| a.0.total_cmp(&b.0))?;
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
        if Autoregression::fit(&even, Autoregression::HIGHEST_ORDER).innovation() < COLOURED {
            return None;
        }
        // What a model lacks grows with the slope as well, so that a jitter must be beyond doubt.
        Some(Self {
            gain: best - gaussian(signals, prior).log + occam - BEYOND_DOUBT,
            time: Known { value: time, standard_error: time * relative },
            left,
        })
    }
}
