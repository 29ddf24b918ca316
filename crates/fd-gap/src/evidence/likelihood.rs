//! Likelihood of simulation errors, with the noise as an unknown.

use std::{borrow::Cow, f64::consts::PI};

use crate::quality::{Autoregression, interval_log_likelihood};

/// Least noise before rounding, in steps of the grid: values at the edge of a cell are no evidence against a
/// simulation that is off by its own standard error.
const SOFT: f64 = 0.15;

/// Least noise of a signal, in sigma: what a logged controller has computed is exact, and its rounding says nothing …
const EXACT: f64 = 1e-3;
/// … and errors up to which it matters.
const NEARLY_EXACT: f64 = 0.1;

/// What is known of the noise of an output before the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoisePrior {
    /// Logarithm of the noise that is expected, in units of sigma.
    pub centre: f64,
    /// Standard deviation of that logarithm.
    pub spread: f64,
    /// Whether it may have a colour.
    pub is_coloured: bool,
    /// Step of the grid that measured values are rounded to after the noise came in, in units of sigma, if that is
    /// coarse beside the noise: a simulation is then judged by the cells that it hits, not by where in the cell it is.
    pub step: Option<f64>,
}

impl NoisePrior {
    /// White noise of size sigma, give or take `spread`.
    ///
    /// ```
    /// use fd_gap::evidence::NoisePrior;
    ///
    /// assert_eq!(NoisePrior::white(0.15).coloured(true).centre, 0.0);
    /// ```
    #[must_use]
    pub fn white(spread: f64) -> Self {
        Self { centre: 0.0, spread, is_coloured: false, step: None }
    }

    /// Noise of size `before` sigma that is rounded to a grid of a `step`, which makes it larger.
    ///
    /// ```
    /// use fd_gap::evidence::NoisePrior;
    ///
    /// let rounded = NoisePrior::white(0.1).rounded(1.0, 2.0);
    /// assert!((rounded.centre.exp() - f64::sqrt(1.0 + 2.0_f64.powi(2) / 12.0)).abs() < 1e-12);
    /// assert!((rounded.before_rounding() - 1.0).abs() < 1e-12);
    /// ```
    #[must_use]
    pub fn rounded(self, before: f64, step: f64) -> Self {
        let before = before.max(SOFT * step);
        Self { centre: before.hypot(of_rounding(step)).ln(), step: Some(step), ..self }
    }

    /// The same size without a grid.
    #[must_use]
    pub fn of_its_size(self) -> Self {
        Self { step: None, ..self }
    }

    /// The noise that is expected before values are rounded, in units of sigma.
    #[must_use]
    pub fn before_rounding(&self) -> f64 {
        let step = self.step.unwrap_or(0.0);
        let squared = (2.0 * self.centre).exp() - of_rounding(step).powi(2);
        squared.max(0.0).sqrt().max(SOFT * step)
    }

    /// The same noise, which may have a colour or not.
    #[must_use]
    pub fn coloured(self, is_coloured: bool) -> Self {
        Self { is_coloured, ..self }
    }

    /// What a logarithm of the noise costs, in units of the log-likelihood.
    #[must_use]
    pub fn cost(&self, log_scale: f64) -> f64 {
        0.5 * ((log_scale - self.centre) / self.spread).powi(2)
    }
}

/// Standard deviation of what rounding to a grid adds.
#[must_use]
pub(crate) fn of_rounding(step: f64) -> f64 {
    step / f64::sqrt(12.0)
}

/// Log-likelihood of the errors of a simulation, and the noise that makes it largest.
#[derive(Clone, Debug, PartialEq)]
pub struct Likelihood {
    /// Logarithm, up to a constant of the data; includes the prior of the noise.
    pub log: f64,
    /// Noise of each output, as a multiple of what it was said to be.
    pub scale: Vec<f64>,
    /// Colour of the noise of each output.
    pub colour: Vec<Autoregression>,
}

/// Gaussian log-likelihood of errors in units of the stated noise (outputs, segments, samples; NaN
/// where nothing was measured).
///
/// The standard deviation of the noise of each output is `s` sigma; `ln s` has a Gaussian prior and
/// is at its best value. Coloured noise has an autoregression of its own, which costs `½ ln n` per coefficient; `s` remains the
/// marginal standard deviation, so that smooth errors of a wrong model are not taken for noise.
#[must_use]
pub fn likelihood(errors: &[Vec<Vec<f64>>], noise: &[NoisePrior]) -> Likelihood {
    let mut sum = Likelihood { log: 0.0, scale: Vec::new(), colour: Vec::new() };
    for (signals, prior) in errors.iter().zip(noise) {
        let signals = &*with_some_noise(signals);
        let cells = prior.step.map(|step| of_cells(signals, prior, step));
        let filtered = (cells.is_none() || prior.is_coloured).then(|| of_filter(signals, prior));
        // Rounding hides a colour or does not.
        let [best, other] = [cells, filtered];
        let Some(one) = best.into_iter().chain(other).max_by(|a, b| a.log.total_cmp(&b.log)) else {
            continue;
        };
        sum.log += one.log;
        sum.scale.push(one.scale);
        sum.colour.push(one.colour);
    }
    sum
}

/// Errors with the least noise that there is, the same for all simulations of a signal.
fn with_some_noise(signals: &[Vec<f64>]) -> Cow<'_, [Vec<f64>]> {
    let size = fd_numeric::rms(signals.iter().flatten().copied().filter(|e| e.is_finite()));
    if NEARLY_EXACT < size {
        return Cow::Borrowed(signals);
    }
    let dithered = |signal: &Vec<f64>| -> Vec<f64> {
        signal.iter().enumerate().map(|(k, error)| error + EXACT * sign(k)).collect()
    };
    Cow::Owned(signals.iter().map(dithered).collect())
}

/// A sign by chance, the same in every run: a multiplicative hash (Knuth).
fn sign(k: usize) -> f64 {
    let hash = (k as u64).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    if hash >> 63 == 0 { 1.0 } else { -1.0 }
}

/// The likelihood of one output.
struct One {
    log: f64,
    scale: f64,
    colour: Autoregression,
}

/// Of noise that a filter may have coloured.
fn of_filter(signals: &[Vec<f64>], prior: &NoisePrior) -> One {
    let slices: Vec<&[f64]> = signals.iter().map(Vec::as_slice).collect();
    let highest = if prior.is_coloured { Autoregression::HIGHEST_ORDER } else { 0 };
    let colour = Autoregression::fit(&slices, highest);
    let (mut n, mut squares, mut spreads) = (0.0_f64, 0.0, 0.0);
    for signal in signals {
        let mut e = vec![0.0; signal.len()];
        colour.whiten(signal, &mut e);
        n += signal.iter().filter(|v| v.is_finite()).count() as f64;
        squares += e.iter().map(|e| e * e).sum::<f64>();
        spreads += colour.log_spread(signal);
    }
    let log_scale = best_log_scale(n, squares, prior);
    let fit = n * log_scale + 0.5 * squares * (-2.0 * log_scale).exp();
    let orders = 0.5 * colour.order() as f64 * n.max(1.0).ln();
    let log = -(fit + prior.cost(log_scale) + spreads + orders);
    One { log, scale: log_scale.exp(), colour }
}

/// Of noise that rounding hides: the log-likelihood of errors of rounded values (without `−½ ln 2π` per sample, as everywhere here), and the size that
/// such errors have.
fn of_cells(signals: &[Vec<f64>], prior: &NoisePrior, step: f64) -> One {
    let errors: Vec<f64> = signals.iter().flatten().copied().filter(|e| e.is_finite()).collect();
    let squares: f64 = errors.iter().map(|e| e * e).sum();
    let largest = (squares / errors.len().max(1) as f64).sqrt();
    let expected = prior.before_rounding();
    let log = |log_scale: f64| {
        let cost = NoisePrior { centre: expected.ln(), ..*prior }.cost(log_scale);
        interval_log_likelihood(&errors, log_scale.exp(), step) - cost
    };
    let [low, high] = [(SOFT * step).ln(), largest.max(expected).ln()];
    let (log_scale, log) = maximum(log, low, high.max(low));
    let constant = 0.5 * errors.len() as f64 * (2.0 * PI).ln();
    let scale = log_scale.exp().hypot(of_rounding(step));
    One { log: log + constant, scale, colour: Autoregression::fit(&[], 0) }
}

/// The place and the value of the top of a function with one hill, by golden sections.
fn maximum(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> (f64, f64) {
    let golden = 0.5 * (f64::sqrt(5.0) - 1.0);
    let mut inner = [high - golden * (high - low), low + golden * (high - low)];
    let mut values = inner.map(&f);
    // To a hundredth of a logarithm: a likelihood is flat at its top.
    while 0.01 < high - low {
        if values[0] < values[1] {
            low = inner[0];
            inner = [inner[1], low + golden * (high - low)];
            values = [values[1], f(inner[1])];
        } else {
            high = inner[1];
            inner = [high - golden * (high - low), inner[0]];
            values = [f(inner[0]), values[0]];
        }
    }
    let best = usize::from(values[0] < values[1]);
    (inner[best], values[best])
}

/// The `l` with the least `n l + E exp(−2 l)/2 + (l − c)²/(2 t²)`, a convex function, by Newton's
/// method.
pub(crate) fn best_log_scale(n: f64, squares: f64, prior: &NoisePrior) -> f64 {
    let precision = prior.spread.powi(-2);
    // From the right, where the exponential is small, Newton could jump; from the left it climbs
    // down step by step without passing the solution.
    let mut l = (0.5 * (squares / n.max(1.0)).ln()).max(prior.centre - 20.0).min(prior.centre);
    for _ in 0..200 {
        let misfit = squares * (-2.0 * l).exp();
        let step = (n - misfit + precision * (l - prior.centre)) / (2.0 * misfit + precision);
        l -= step;
        if step.abs() < 1e-12 {
            break;
        }
    }
    l
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    #[test]
    fn golden_sections_return_the_best_of_what_they_tried() {
        for k in 0..60 {
            // Some hills have their top beyond the end.
            let top = -1.2 + 0.04 * f64::from(k);
            let best = Cell::new(f64::NEG_INFINITY);
            let hill = |x: f64| {
                let height = -(x - top).powi(2);
                best.set(height.max(best.get()));
                height
            };
            let (place, height) = maximum(hill, -1.0, 1.0);
            assert!((place - top.clamp(-1.0, 1.0)).abs() <= 0.01, "{place} {top}");
            assert_eq!(height.to_bits(), best.get().to_bits(), "{place} {top}");
        }
    }
}
