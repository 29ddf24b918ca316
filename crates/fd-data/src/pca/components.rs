//! How many principal components there are.

use faer::Mat;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::{
    error::DataError,
    samples::{Scaling, centre_columns, covariance},
    spectrum::Spectrum,
};

/// The rule for the number of components.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Components {
    /// So many.
    Count(usize),
    /// As many as explain this share of the variance, between 0 and 1.
    Variance(f64),
    /// Those with an eigenvalue that independent Gaussian channels reach in 5 % of logs of as many samples: drawn
    /// so many times from this seed, in windows like those of the log. Horn (1965) compares with their mean, where
    /// an eigenvalue of noise is above in every other log, so that the seed decides; the 95 % point is that of
    /// Glorfeld (1995), here mean and spread of a Gaussian, for which few draws are enough.
    Parallel {
        /// How many times.
        draws: usize,
        /// Seed of the random numbers.
        seed: u64,
    },
}

impl Default for Components {
    fn default() -> Self {
        Self::Parallel { draws: 10, seed: 0 }
    }
}

/// What a set of windows is like.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    /// Windows.
    pub rows: usize,
    /// Channels of a sample.
    pub width: usize,
    /// Window length minus one.
    pub order: usize,
    /// Units of the channels.
    pub scaling: Scaling,
}

impl Components {
    /// The number for a spectrum; at least one, at most its rank.
    pub(super) fn count(self, spectrum: &Spectrum, extent: Extent) -> Result<usize, DataError> {
        let rank = spectrum.rank().max(1);
        match self {
            Self::Count(count) if 0 < count && count <= rank => Ok(count),
            Self::Count(count) => Err(DataError::Setting {
                setting: "components",
                expected: format!("1 to {rank}, the rank of the healthy windows"),
                found: count as f64,
            }),
            Self::Variance(share) if share > 0.0 && share < 1.0 => {
                let total: f64 = spectrum.values.iter().sum();
                let mut explained = 0.0;
                let enough = spectrum.values.iter().position(|value| {
                    explained += value;
                    share * total <= explained
                });
                Ok(enough.map_or(rank, |last| last + 1).min(rank))
            }
            Self::Variance(found) => {
                let expected = "between 0 and 1".to_owned();
                Err(DataError::Setting { setting: "components.variance", expected, found })
            }
            Self::Parallel { draws: 0, .. } => {
                let expected = "at least 1".to_owned();
                Err(DataError::Setting { setting: "components.draws", expected, found: 0.0 })
            }
            Self::Parallel { .. } if extent.scaling == Scaling::None => Err(DataError::Setting {
                setting: "components",
                expected: "a number or a share of the variance for channels that are not scaled"
                    .to_owned(),
                found: f64::NAN,
            }),
            Self::Parallel { draws, seed } => {
                let chance = by_chance(extent, draws, seed)?;
                let above = spectrum.values.iter().zip(&chance).take_while(|(v, c)| v > c);
                Ok(above.count().clamp(1, rank))
            }
        }
    }
}

/// The 95 % quantile of a standard Gaussian.
const ONE_SIDED: f64 = 1.645;

/// What 5 % of the eigenvalues of windows of independent channels of unit variance exceed, rank by rank; of a single
/// draw its eigenvalues.
fn by_chance(extent: Extent, draws: usize, seed: u64) -> Result<Vec<f64>, DataError> {
    let Extent { rows, width, order, .. } = extent;
    let columns = width * (order + 1);
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let (mut mean, mut squares) = (vec![0.0; columns], vec![0.0; columns]);
    for drawn_before in 0..draws {
        let series: Vec<f64> =
            (0..(rows + order) * width).map(|_| StandardNormal.sample(&mut random)).collect();
        let mut windows = Mat::from_fn(rows, columns, |i, j| series[i * width + j]);
        centre_columns(&mut windows);
        let cov = covariance(windows.as_ref(), windows.as_ref());
        let drawn = Spectrum::of(cov.as_ref(), "eigenvalues of chance")?;
        for ((mean, square), value) in mean.iter_mut().zip(&mut squares).zip(&drawn.values) {
            let off = value - *mean;
            *mean += off / (drawn_before + 1) as f64;
            *square += off * (value - *mean);
        }
    }
    let spread = |square: &f64| (square / draws.saturating_sub(1).max(1) as f64).sqrt();
    Ok(mean.iter().zip(&squares).map(|(mean, square)| mean + ONE_SIDED * spread(square)).collect())
}
