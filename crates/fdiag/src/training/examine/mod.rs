//! Is a healthy log fit to be learned from? A fault in it, a drift, too little excitation.
//!
//! What the learned bias leaves of the residual of a healthy log should be noise about zero, and what the
//! inputs still explain of it is a matter of the bias model. A lasting jump, a trend or single samples far out
//! are neither: they are what a fault, an incipient fault or a changing plant leaves. And inputs that move in
//! fewer independent ways than the bias model has parameters cannot tell these parameters apart.
//!
//! # When not to rely on it
//!
//! A fault that is there throughout the log is part of what is normal then; nothing in the log itself can
//! tell. One that begins with a change of the inputs is explained by them.

mod excitation;
mod residual;

use fd_model::figure;
use serde::{Deserialize, Serialize};

pub use self::excitation::inputs_move;
use self::{excitation::excitation, residual::shape};
use super::{
    error::TrainingError,
    trace::Trace,
    train::{Healthy, Trained},
};

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

/// What speaks against some healthy logs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Examination {
    /// For each log, in their order.
    pub logs: Vec<Vec<Doubt>>,
    /// Of what is learned from, all logs together.
    pub together: Vec<Doubt>,
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

/// Examines healthy logs with the diagnosis that was trained on them.
///
/// # Errors
///
/// Returns an error when a log has other channels than the model.
pub fn examine(trained: &Trained, healthy: &[Healthy<'_>]) -> Result<Examination, TrainingError> {
    let mut pipeline = trained.silent()?;
    let mut examination =
        Examination { together: excitation(trained, healthy), ..Examination::default() };
    for log in healthy {
        fd_core::stage::Stage::reset(&mut pipeline);
        let trace = Trace::of(&mut pipeline, log.record)?;
        examination.logs.push(of_log(log, &trace));
    }
    Ok(examination)
}

fn of_log(log: &Healthy<'_>, trace: &Trace) -> Vec<Doubt> {
    // Only samples before the first complete one are refused: missing ones are held.
    let row = |k: usize| k + trace.refused;
    let kept: Vec<usize> = (0..trace.len())
        .filter(|&k| trace.compensating[k] && log.record.is_complete(row(k)))
        .collect();
    if kept.len() < residual::LEAST {
        return vec![Doubt::TooShort { samples: kept.len(), needed: residual::LEAST }];
    }
    let inputs: Vec<Vec<f64>> = (0..log.record.inputs().len())
        .map(|i| kept.iter().map(|&k| log.record.u(row(k))[i]).collect())
        .collect();
    let mut doubts = Vec::new();
    for residual in 0..trace.channels {
        let e: Vec<f64> =
            kept.iter().map(|&k| trace.compensated[k * trace.channels + residual]).collect();
        let found = shape(&inputs, &e);
        let time = |at: usize| kept.get(at).map_or(f64::NAN, |&k| trace.time[k]);
        if let Some((at, size, deviations)) = found.jump {
            doubts.push(Doubt::Jump { residual, at_s: time(at), size, deviations });
        }
        if let Some((size, deviations)) = found.drift {
            doubts.push(Doubt::Drift { residual, size, deviations });
        }
        if let Some((first, samples, largest)) = found.outliers {
            let first_s = time(first);
            doubts.push(Doubt::Outliers { residual, samples, first_s, largest });
        }
    }
    doubts
}
