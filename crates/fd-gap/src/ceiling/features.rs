//! A small nonlinear difference equation: random features, ridge regression.

use faer::{Mat, Side, prelude::Solve};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Lags of inputs and simulated outputs, in samples.
const LAGS: [usize; 7] = [0, 1, 2, 4, 8, 16, 32];
/// Random features.
const FEATURES: usize = 60;
/// Spread of the offsets of the features.
const OFFSETS: f64 = 0.6;
/// Largest prediction, in largest residuals of the training.
const LARGEST: f64 = 2.0;

/// Signals of a log, column by column: drivers, and the residual of one output.
#[derive(Clone, Debug)]
pub(super) struct Example {
    pub(super) drivers: Vec<Vec<f64>>,
    /// NaN where it is not known.
    pub(super) residual: Vec<f64>,
}

/// `r(k) = w·φ(x(k)) + c·x(k) + c₀` with `x(k)` lagged drivers and `na` past values of `r`, all
/// standardised, and `φ` random hyperbolic tangents (Huang, Zhu & Siew 2006).
#[derive(Clone, Debug)]
pub(super) struct Network {
    na: usize,
    /// Mean and inverse spread of each regressor.
    scaling: Vec<[f64; 2]>,
    /// Weights and offset of each feature.
    hidden: Vec<Vec<f64>>,
    weights: Vec<f64>,
    largest: f64,
}

impl Network {
    /// Fits one-step predictions with a ridge; `None` without data.
    pub(super) fn fit(examples: &[Example], na: usize, ridge: f64, seed: u64) -> Option<Self> {
        let mut rows: Vec<(Vec<f64>, f64)> = Vec::new();
        for example in examples {
            for (k, r) in example.residual.iter().enumerate() {
                let past = (1..=na).map(|lag| k.checked_sub(lag).map(|k| example.residual[k]));
                let past: Option<Vec<f64>> = past.collect();
                let Some(past) = past.filter(|p| r.is_finite() && p.iter().all(|v| v.is_finite()))
                else {
                    continue;
                };
                rows.push((regressor(&example.drivers, k, &past), *r));
            }
        }
        let n = rows.len() as f64;
        let width = rows.first()?.0.len();
        let scaling: Vec<[f64; 2]> = (0..width)
            .map(|i| {
                let mean = rows.iter().map(|(x, _)| x[i]).sum::<f64>() / n;
                let variance = rows.iter().map(|(x, _)| (x[i] - mean).powi(2)).sum::<f64>() / n;
                let spread = variance.sqrt();
                // What does not move says nothing.
                [mean, if 1e-9 * mean.abs() < spread { 1.0 / spread } else { 0.0 }]
            })
            .collect();
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let size = 1.5 / (width as f64).sqrt();
        let mut draw = |size: f64| size * (2.0 * random.random::<f64>() - 1.0) * f64::sqrt(3.0);
        let sizes: Vec<f64> = std::iter::repeat_n(size, width).chain([OFFSETS]).collect();
        let hidden: Vec<Vec<f64>> =
            (0..FEATURES).map(|_| sizes.iter().map(|size| draw(*size)).collect()).collect();
        let largest = rows.iter().map(|(_, r)| r.abs()).fold(0.0, f64::max);
        let mut network =
            Self { na, scaling, hidden, weights: Vec::new(), largest: LARGEST * largest };
        let m = FEATURES + width + 1;
        let mut gram = Mat::<f64>::zeros(m, m);
        let mut right = Mat::<f64>::zeros(m, 1);
        for (x, r) in &rows {
            let phi = network.features(x);
            for i in 0..m {
                right[(i, 0)] += phi[i] * r;
                for j in 0..=i {
                    gram[(i, j)] += phi[i] * phi[j];
                }
            }
        }
        for i in 0..m {
            gram[(i, i)] += ridge * n;
        }
        let solution = gram.llt(Side::Lower).ok()?.solve(&right);
        network.weights = (0..m).map(|i| solution[(i, 0)]).collect();
        Some(network)
    }

    fn features(&self, x: &[f64]) -> Vec<f64> {
        let scaled: Vec<f64> =
            x.iter().zip(&self.scaling).map(|(x, [mean, scale])| (x - mean) * scale).collect();
        let hidden = self.hidden.iter().map(|w| {
            let sum: f64 = w.iter().zip(&scaled).map(|(w, x)| w * x).sum();
            (sum + w.last().copied().unwrap_or(0.0)).tanh()
        });
        hidden.chain(scaled.iter().copied()).chain([1.0]).collect()
    }

    /// The residual in free run from rest.
    pub(super) fn run(&self, drivers: &[Vec<f64>]) -> Vec<f64> {
        let samples = drivers.first().map_or(0, Vec::len);
        let mut past = vec![0.0; self.na];
        let step = |k: usize| {
            let phi = self.features(&regressor(drivers, k, &past));
            let value: f64 = phi.iter().zip(&self.weights).map(|(p, w)| p * w).sum();
            let value = value.clamp(-self.largest, self.largest);
            if !past.is_empty() {
                past.rotate_right(1);
                past[0] = value;
            }
            value
        };
        (0..samples).map(step).collect()
    }
}

/// Lagged drivers (before the log they were as at its start), then past residuals.
fn regressor(drivers: &[Vec<f64>], k: usize, past: &[f64]) -> Vec<f64> {
    let lagged = |signal: &Vec<f64>| LAGS.map(|lag| signal[k.saturating_sub(lag)]);
    drivers.iter().flat_map(lagged).chain(past.iter().copied()).collect()
}
