//! Likelihood of simulation errors, with the noise as an unknown.

use crate::quality::Autoregression;

/// What is known of the noise of an output before the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoisePrior {
    /// Logarithm of the noise that is expected, in units of sigma.
    pub centre: f64,
    /// Standard deviation of that logarithm.
    pub spread: f64,
    /// Whether it may have a colour.
    pub is_coloured: bool,
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
        Self { centre: 0.0, spread, is_coloured: false }
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
        sum.log -=
            fit + prior.cost(log_scale) + spreads + 0.5 * colour.order() as f64 * n.max(1.0).ln();
        sum.scale.push(log_scale.exp());
        sum.colour.push(colour);
    }
    sum
}

/// The `l` with the least `n l + E exp(−2 l)/2 + (l − c)²/(2 t²)`, a convex function, by Newton's
/// method.
fn best_log_scale(n: f64, squares: f64, prior: &NoisePrior) -> f64 {
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
