//! White and autoregressive Gaussian noise.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};

use crate::signal::{
    check::{finite, in_range},
    error::SignalError,
};

/// Independent Gaussian samples of mean zero.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WhiteNoise {
    /// Standard deviation of a sample, in the unit of the channel.
    pub sigma: f64,
    /// Seed of the draw.
    pub seed: u64,
}

/// `w[k] = Σ aᵢ w[k − i] + e[k]` with white Gaussian `e`, in steady state from the first sample
/// on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArNoise {
    /// Coefficients `a₁, a₂, …` (per sample); all roots of `zᵖ − a₁ zᵖ⁻¹ − … − aₚ` inside the
    /// unit circle.
    pub coefficients: Vec<f64>,
    /// Standard deviation of `w`, not of `e`, in the unit of the channel.
    pub sigma: f64,
    /// Seed of the draw.
    pub seed: u64,
}

impl WhiteNoise {
    /// Noise of standard deviation `sigma`.
    ///
    /// ```
    /// # use fd_model::signal::WhiteNoise;
    /// let noise = WhiteNoise::new(0.1, 1);
    /// assert_eq!(noise.values(10)?, noise.values(10)?);
    /// # Ok::<(), fd_model::signal::SignalError>(())
    /// ```
    #[must_use]
    pub fn new(sigma: f64, seed: u64) -> Self {
        Self { sigma, seed }
    }

    /// The first `n` samples.
    ///
    /// # Errors
    ///
    /// Returns an error when `sigma` is negative or not finite.
    pub fn values(&self, n: usize) -> Result<Vec<f64>, SignalError> {
        in_range("white-noise", "sigma", "0 or above", self.sigma, 0.0 <= self.sigma)?;
        Ok(standard_normal(self.seed).map(|e| self.sigma * e).take(n).collect())
    }
}

impl ArNoise {
    /// Noise with the given coefficients and marginal standard deviation.
    ///
    /// ```
    /// # use fd_model::signal::ArNoise;
    /// let drift = ArNoise::new(vec![0.99], 0.1, 1).values(100)?;
    /// assert!(ArNoise::new(vec![1.01], 0.1, 1).values(100).is_err());
    /// # Ok::<(), fd_model::signal::SignalError>(())
    /// ```
    #[must_use]
    pub fn new(coefficients: Vec<f64>, sigma: f64, seed: u64) -> Self {
        Self { coefficients, sigma, seed }
    }

    /// The first `n` samples.
    ///
    /// The first `p` samples are drawn from their exact joint distribution: sample `m` is the
    /// best linear prediction from the `m` samples before it plus an innovation of the variance
    /// of that prediction (Durbin-Levinson).
    ///
    /// # Errors
    ///
    /// Returns an error when a number is not finite, `sigma` is negative or the coefficients are
    /// not stable.
    pub fn values(&self, n: usize) -> Result<Vec<f64>, SignalError> {
        in_range("ar-noise", "sigma", "0 or above", self.sigma, 0.0 <= self.sigma)?;
        let predictors = self.predictors()?;
        let p = self.coefficients.len();
        let mut w: Vec<f64> = Vec::with_capacity(n);
        for e in standard_normal(self.seed).take(n) {
            let Predictor { coefficients, spread } = &predictors[w.len().min(p)];
            let prediction: f64 = coefficients.iter().zip(w.iter().rev()).map(|(a, w)| a * w).sum();
            w.push(prediction + self.sigma * spread * e);
        }
        Ok(w)
    }

    /// Best predictors from 0, 1, …, p past samples, by the backward Levinson recursion
    /// `a⁽ᵐ⁻¹⁾ᵢ = (a⁽ᵐ⁾ᵢ + kₘ a⁽ᵐ⁾ₘ₋ᵢ) / (1 − kₘ²)` with `kₘ = a⁽ᵐ⁾ₘ`; the autoregression is
    /// stable if and only if all `|kₘ| < 1`.
    fn predictors(&self) -> Result<Vec<Predictor>, SignalError> {
        self.coefficients.iter().try_for_each(|&a| finite("ar-noise", "coefficients", a))?;
        let mut a = self.coefficients.clone();
        let mut predictors = Vec::with_capacity(a.len() + 1);
        let mut reflections = Vec::with_capacity(a.len());
        while let Some(&k) = a.last() {
            if 1.0 <= k.abs() {
                return Err(SignalError::UnstableNoise { order: a.len(), value: k });
            }
            let m = a.len();
            let lower = (0..m - 1).map(|i| (a[i] + k * a[m - 2 - i]) / (1.0 - k * k)).collect();
            predictors.push(Predictor { coefficients: a, spread: 1.0 });
            reflections.push(k);
            a = lower;
        }
        predictors.push(Predictor { coefficients: a, spread: 1.0 });
        predictors.reverse();
        // The variance left after m samples is the product of 1 − k² up to order m.
        let mut variance = 1.0;
        for (predictor, k) in predictors.iter_mut().skip(1).zip(reflections.iter().rev()) {
            variance *= 1.0 - k * k;
            predictor.spread = f64::sqrt(variance);
        }
        Ok(predictors)
    }
}

/// Prediction of a sample of unit variance from those before it, the latest first.
struct Predictor {
    coefficients: Vec<f64>,
    /// Standard deviation of the prediction error.
    spread: f64,
}

fn standard_normal(seed: u64) -> impl Iterator<Item = f64> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    std::iter::repeat_with(move || StandardNormal.sample(&mut rng))
}
