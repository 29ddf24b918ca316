//! A small nonlinear difference equation: random features, ridge regression.

use faer::{Mat, prelude::Solve};
use fd_numeric::{
    dense::{Dense, add_gram},
    wide::dot,
};
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

/// Rows of regressors that are multiplied at a time.
const BLOCK: usize = 256;

/// Signals of a log, column by column: drivers, and the residual of one output.
#[derive(Clone, Debug)]
pub(super) struct Example<'a> {
    pub drivers: &'a [Vec<f64>],
    /// NaN where it is not known.
    pub residual: Vec<f64>,
}

/// Random features of lagged drivers `x(k)` and `na` past values of `r`, all standardised.
#[derive(Clone, Debug)]
struct Features {
    na: usize,
    /// Mean and inverse spread of each regressor.
    scaling: Vec<[f64; 2]>,
    /// Weights and offset of each feature.
    hidden: Vec<Vec<f64>>,
}

/// One-step predictions of a residual by features, before a ridge is chosen.
#[derive(Clone, Debug)]
pub(super) struct Regression {
    features: Features,
    /// Scalar products of the features with each other, and with the residual.
    gram: Mat<f64>,
    right: Mat<f64>,
    rows: f64,
    largest: f64,
}

/// `r(k) = w·φ(x(k)) + c·x(k) + c₀` with `φ` random hyperbolic tangents (Huang, Zhu & Siew 2006).
#[derive(Clone, Debug)]
pub(super) struct Network {
    features: Features,
    weights: Vec<f64>,
    largest: f64,
}

impl Regression {
    /// The normal equations of examples; `None` without data.
    pub(super) fn new(examples: &[Example<'_>], na: usize, seed: u64) -> Option<Self> {
        let mut rows: Vec<(Vec<f64>, f64)> = Vec::new();
        for example in examples {
            for (k, r) in example.residual.iter().enumerate() {
                let past = (1..=na).map(|lag| k.checked_sub(lag).map(|k| example.residual[k]));
                let past: Option<Vec<f64>> = past.collect();
                let Some(past) = past.filter(|p| r.is_finite() && p.iter().all(|v| v.is_finite()))
                else {
                    continue;
                };
                rows.push((regressor(example.drivers, k, &past), *r));
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
        let features = Features { na, scaling, hidden };
        let m = FEATURES + width + 1;
        let mut gram = Mat::<f64>::zeros(m, m);
        let mut right = Mat::<f64>::zeros(m, 1);
        for rows in rows.chunks(BLOCK) {
            let phi: Vec<Vec<f64>> = rows.iter().map(|(x, _)| features.of(x)).collect();
            for (phi, (_, r)) in phi.iter().zip(rows) {
                phi.iter().enumerate().for_each(|(i, phi)| right[(i, 0)] += phi * r);
            }
            let phi = Mat::from_fn(m, rows.len(), |i, k| phi[k][i]);
            add_gram(gram.as_mut(), phi.as_ref());
        }
        let largest = LARGEST * rows.iter().map(|(_, r)| r.abs()).fold(0.0, f64::max);
        Some(Self { features, gram, right, rows: n, largest })
    }

    /// The fit with a ridge; `None` where that is not enough.
    pub(super) fn with_ridge(&self, ridge: f64) -> Option<Network> {
        let mut gram = self.gram.clone();
        for i in 0..gram.nrows() {
            gram[(i, i)] += ridge * self.rows;
        }
        let solution = gram.cholesky().ok()?.solve(&self.right);
        let weights = (0..gram.nrows()).map(|i| solution[(i, 0)]).collect();
        Some(Network { features: self.features.clone(), weights, largest: self.largest })
    }
}

impl Features {
    /// Features, the standardised regressor, and one.
    fn of(&self, x: &[f64]) -> Vec<f64> {
        let scaled: Vec<f64> =
            x.iter().zip(&self.scaling).map(|(x, [mean, scale])| (x - mean) * scale).collect();
        let hidden = self.hidden.iter().map(|w| {
            let (offset, w) = w.split_last().unwrap_or((&0.0, &[]));
            (dot(&scaled, w) + offset).tanh()
        });
        hidden.chain(scaled.iter().copied()).chain([1.0]).collect()
    }
}

impl Network {
    /// The residual in free run from rest.
    pub(super) fn run(&self, drivers: &[Vec<f64>]) -> Vec<f64> {
        let samples = drivers.first().map_or(0, Vec::len);
        let mut past = vec![0.0; self.features.na];
        let step = |k: usize| {
            let phi = self.features.of(&regressor(drivers, k, &past));
            let value = dot(&phi, &self.weights).clamp(-self.largest, self.largest);
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
