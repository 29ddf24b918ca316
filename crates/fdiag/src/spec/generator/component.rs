//! What a data-driven generator keeps of its components, and what of them is the residual.

use serde::{Deserialize, Serialize};

/// How many principal components.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum ComponentSpec {
    /// So many.
    Count {
        /// The number.
        count: usize,
    },
    /// As many as explain a share of the variance.
    Variance {
        /// The share, between 0 and 1.
        share: f64,
    },
    /// Those that stand above what independent channels would show.
    ParallelAnalysis {
        /// How many times independent channels are drawn.
        #[serde(default = "default_draws")]
        draws: usize,
        /// Seed of the random numbers.
        #[serde(default)]
        seed: u64,
    },
}

fn default_draws() -> usize {
    10
}

impl Default for ComponentSpec {
    fn default() -> Self {
        Self::ParallelAnalysis { draws: default_draws(), seed: 0 }
    }
}

/// What of a monitor is the residual.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PartSpec {
    /// What the components leave: near zero for a healthy plant.
    #[default]
    Residual,
    /// The components themselves, of unit variance for a healthy plant.
    Scores,
    /// The statistics, each over its limit of 99 % for independent Gaussian samples.
    Statistics,
}
