//! All runs of an engine through one residual generator and one bias model.

use fd_model::Record;
use fdiag::training::{Subtracted, Subtraction, Trained, TrainingError};
use thiserror::Error;

use super::plants::Runs;

/// A generator cannot watch a plant.
#[derive(Debug, Error)]
pub(super) enum ResidualError {
    /// It cannot be built or run.
    #[error(transparent)]
    Training(#[from] TrainingError),
    /// It has no answer where nothing is wrong.
    #[error("no finite residual at sample {sample} of fault-free run {run}: it has lost the plant")]
    NoValue { run: usize, sample: usize },
}

/// Residuals, row by row.
pub(super) struct Residuals {
    /// Of the runs without an injected fault, whole.
    pub healthy: Vec<Vec<f64>>,
    /// Of the same with each kind of fault in each size, from the start of the faults on: before it they
    /// are the same.
    pub faulty: Vec<Vec<Vec<Vec<f64>>>>,
}

impl Residuals {
    /// The primary residuals; `start` is the first sample with a fault.
    pub(super) fn primary(
        trained: &Trained,
        runs: &Runs,
        start: usize,
    ) -> Result<Self, ResidualError> {
        let mut generator = trained.primary()?;
        let (mut healthy, mut faulty) = (Vec::new(), Vec::new());
        for (i, record) in runs.healthy.iter().enumerate() {
            let residual = generator.whole(record, start)?;
            // A filter that has lost the plant has no residual, which must not pass for a small one.
            if let Some(at) = residual.iter().position(|value| !value.is_finite()) {
                let sample = at / (residual.len() / record.len().max(1)).max(1);
                return Err(ResidualError::NoValue { run: i + 1, sample });
            }
            healthy.push(residual);
            if let Some(kinds) = runs.faulty.get(i) {
                faulty.push(each(kinds, |record, _| generator.again(record, start))?);
            }
        }
        Ok(Self { healthy, faulty })
    }

    /// What a bias model leaves of these primary residuals.
    pub(super) fn compensated(
        &self,
        trained: &Trained,
        runs: &Runs,
        start: usize,
    ) -> Result<Self, TrainingError> {
        let mut subtraction = trained.subtraction()?;
        let (mut healthy, mut faulty) = (Vec::new(), Vec::new());
        for (i, (record, primary)) in runs.healthy.iter().zip(&self.healthy).enumerate() {
            let whole = subtraction.of(record, primary)?;
            if let (Some(kinds), Some(tails)) = (runs.faulty.get(i), self.faulty.get(i)) {
                let channels = primary.len() / record.len().max(1);
                let before = &primary[..start.min(record.len()) * channels];
                faulty.push(each(kinds, |broken, (k, s)| {
                    // What a controller or a wrong sensor makes of the inputs moves the bias too.
                    let known = same_inputs(record, broken, start).then_some(&whole);
                    tail(&mut subtraction, known, broken, before, &tails[k][s])
                })?);
            }
            healthy.push(whole.residual);
        }
        Ok(Self { healthy, faulty })
    }
}

/// Every kind and size of fault.
fn each(
    kinds: &[Vec<Record>],
    mut residual: impl FnMut(&Record, (usize, usize)) -> Result<Vec<f64>, TrainingError>,
) -> Result<Vec<Vec<Vec<f64>>>, TrainingError> {
    kinds
        .iter()
        .enumerate()
        .map(|(k, sizes)| {
            sizes.iter().enumerate().map(|(s, record)| residual(record, (k, s))).collect()
        })
        .collect()
}

fn same_inputs(healthy: &Record, broken: &Record, start: usize) -> bool {
    (start..healthy.len()).all(|k| healthy.u(k) == broken.u(k))
}

/// The compensated residual from the start of a fault on, where the primary one is `after`; `healthy` is what became of the
/// run without the fault, if its inputs are the same.
fn tail(
    subtraction: &mut Subtraction,
    healthy: Option<&Subtracted>,
    record: &Record,
    before: &[f64],
    after: &[f64],
) -> Result<Vec<f64>, TrainingError> {
    if let Some(known) = healthy.and_then(|healthy| healthy.again(before.len(), after)) {
        return Ok(known);
    }
    let mut whole = subtraction.of(record, &[before, after].concat())?.residual;
    Ok(whole.split_off(before.len()))
}
