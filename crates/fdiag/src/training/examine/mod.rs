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

mod doubt;
mod excitation;
mod residual;

use serde::{Deserialize, Serialize};

pub use self::{
    doubt::{Doubt, Names},
    excitation::inputs_move,
};
use self::{excitation::excitation, residual::shape};
use super::{error::TrainingError, healthy::Healthy, trace::Trace, trained::Trained};

/// What speaks against some healthy logs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Examination {
    /// For each log, in their order.
    pub logs: Vec<Vec<Doubt>>,
    /// Of what is learned from, all logs together.
    pub together: Vec<Doubt>,
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
    let kept: Vec<usize> =
        (0..trace.len()).filter(|&k| trace.compensating[k] && log.record.is_complete(k)).collect();
    if kept.len() < residual::LEAST {
        return vec![Doubt::TooShort { samples: kept.len(), needed: residual::LEAST }];
    }
    let inputs: Vec<Vec<f64>> = (0..log.record.inputs().len())
        .map(|i| kept.iter().map(|&k| log.record.u(k)[i]).collect())
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
