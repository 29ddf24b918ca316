//! What speaks against learning from a log, and how it is said.

use fd_model::figure;
use serde::{Deserialize, Serialize};

/// Something that speaks against learning from a healthy log. Residuals are compensated, in the units of the
/// model; times in s.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Doubt {
    /// A residual jumps and stays.
    Jump {
        /// Index of the residual.
        residual: usize,
        /// When.
        at_s: f64,
        /// By how much.
        size: f64,
        /// The same in standard errors.
        deviations: f64,
    },
    /// A residual drifts.
    Drift {
        /// Index of the residual.
        residual: usize,
        /// By how much over the log.
        size: f64,
        /// The same in standard errors.
        deviations: f64,
    },
    /// Single samples of a residual are far outside the others.
    Outliers {
        /// Index of the residual.
        residual: usize,
        /// How many samples.
        samples: usize,
        /// When the first one is.
        first_s: f64,
        /// The largest, relative to the deviation of the others.
        largest: f64,
    },
    /// An input does not move.
    StillInput {
        /// Index of the input.
        input: usize,
    },
    /// An input moves in fewer independent ways than there are parameters to find.
    LittleExcitation {
        /// Index of the input.
        input: usize,
        /// In how many it moves.
        ways: usize,
        /// How many are needed.
        needed: usize,
    },
    /// The log leaves too few samples to look at.
    TooShort {
        /// Compensated samples.
        samples: usize,
        /// Least number.
        needed: usize,
    },
}

/// What channels are called in words: name, unit and what one of the model is worth in it.
#[derive(Clone, Debug)]
pub struct Names<'a> {
    /// Of each residual.
    pub residuals: Vec<(&'a str, &'a str, f64)>,
    /// Of each input.
    pub inputs: Vec<&'a str>,
}

impl Doubt {
    /// What it is and what it may mean, as a sentence without its full stop.
    #[must_use]
    pub fn in_words(&self, names: &Names<'_>) -> String {
        let of =
            |residual: usize| names.residuals.get(residual).copied().unwrap_or(("?", "1", 1.0));
        let input = |at: usize| names.inputs.get(at).copied().unwrap_or("?");
        match *self {
            Self::Jump { residual, at_s, size, .. } => {
                let (name, unit, scale) = of(residual);
                format!(
                    "the residual of {name} jumps by {} {unit} at {} s and stays there, which the inputs \
                     do not explain: a fault may have been learned as normal",
                    figure(scale * size),
                    figure(at_s),
                )
            }
            Self::Drift { residual, size, .. } => {
                let (name, unit, scale) = of(residual);
                format!(
                    "the residual of {name} drifts by {} {unit} over the log, which the inputs do not \
                     explain: an incipient fault, or a plant that changes",
                    figure(scale * size),
                )
            }
            Self::Outliers { residual, samples, first_s, largest } => format!(
                "{samples} samples of the residual of {} are far outside the others, the first at {} s, the \
                 largest {} deviations out: a short fault, or bad readings",
                of(residual).0,
                figure(first_s),
                figure(largest),
            ),
            Self::StillInput { input: at } => {
                format!(
                    "the input {} does not move, so nothing is learned of what it does",
                    input(at)
                )
            }
            Self::LittleExcitation { input: at, ways, needed } => format!(
                "the input {} moves in {ways} independent ways and {needed} are needed: the bias holds for \
                 inputs like these only",
                input(at),
            ),
            Self::TooShort { samples, needed } => format!(
                "it leaves {samples} compensated samples, at least {needed} are needed to look for faults in it"
            ),
        }
    }
}
