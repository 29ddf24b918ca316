//! The stages of a trained diagnosis one by one, for studies that send many complete logs through many of them.

use std::ops::Range;

use fd_compensate::residual_compensation::ResidualCompensator;
use fd_core::{
    Frame, IoDims, Snapshot,
    stage::{Compensator, Phase, ResidualGenerator, Stage},
};
use fd_model::Record;

use super::{
    error::TrainingError, running::RunningBias, structure::DynIdentifier, trained::Trained,
};
use crate::spec::DetectorSpec;

/// The residual generator alone.
pub struct Primary {
    generator: Box<dyn ResidualGenerator>,
    /// After the samples before the fork of the last whole log.
    fork: Option<Snapshot>,
}

impl Primary {
    /// The primary residual of a whole log, from rest. What comes after sample `fork` can be repeated
    /// by [`Primary::again`].
    ///
    /// # Errors
    ///
    /// Returns an error when a row of the log does not fit the channels or is not finite.
    pub fn whole(&mut self, record: &Record, fork: usize) -> Result<Vec<f64>, TrainingError> {
        self.generator.reset();
        let fork = fork.min(record.len());
        let mut residual = self.run(record, 0..fork)?;
        self.fork = Some(Snapshot::of(&mut self.generator));
        residual.extend(self.run(record, fork..record.len())?);
        Ok(residual)
    }

    /// The primary residual from sample `fork` on of a log that is the last whole one before it.
    ///
    /// # Errors
    ///
    /// Returns an error when a row of the log does not fit the channels or is not finite.
    pub fn again(&mut self, record: &Record, fork: usize) -> Result<Vec<f64>, TrainingError> {
        let fork = fork.min(record.len());
        let restored = self.fork.as_ref().is_some_and(|f| f.restore(&mut self.generator).is_ok());
        debug_assert!(restored, "a whole log comes first");
        self.run(record, fork..record.len())
    }

    fn run(&mut self, record: &Record, samples: Range<usize>) -> Result<Vec<f64>, TrainingError> {
        let (io, channels) = (self.generator.io(), self.generator.residual_len());
        let mut residual = vec![0.0; samples.len() * channels];
        for (k, r) in samples.zip(residual.chunks_exact_mut(channels)) {
            self.generator.step(Frame::new(io, k as u64, record.u(k), record.y(k))?, r);
        }
        Ok(residual)
    }
}

/// The compensator alone.
pub struct Subtraction {
    compensator: ResidualCompensator<f64, DynIdentifier, RunningBias>,
    io: IoDims,
}

/// What became of a primary residual.
pub struct Subtracted {
    /// The compensated residual, row by row.
    pub residual: Vec<f64>,
    /// The bias `μ̂`, row by row.
    bias: Vec<f64>,
    /// First number of the residual from which on the switch was open throughout.
    open_from: usize,
}

impl Subtraction {
    /// The compensated residual of a whole log without missing samples.
    ///
    /// # Errors
    ///
    /// Returns an error when a row of the log does not fit the channels or is not finite.
    pub fn of(&mut self, record: &Record, primary: &[f64]) -> Result<Subtracted, TrainingError> {
        let channels = self.compensator.residual_len();
        self.compensator.reset();
        let mut residual = vec![0.0; primary.len()];
        let mut bias = Vec::with_capacity(primary.len());
        let mut open_from = 0;
        let rows = primary.chunks_exact(channels).zip(residual.chunks_exact_mut(channels));
        for (k, (r, r_star)) in rows.enumerate() {
            let frame = Frame::new(self.io, k as u64, record.u(k), record.y(k))?;
            if self.compensator.step(frame, r, r_star).phase != Phase::Compensating {
                open_from = (k + 1) * channels;
            }
            bias.extend_from_slice(self.compensator.bias());
        }
        Ok(Subtracted { residual, bias, open_from })
    }
}

impl Subtracted {
    /// The compensated residual after the first `before` numbers, of a log with the same inputs and
    /// another primary residual from there on; `None` if the switch was not open throughout. While it is
    /// open, `μ̂` is simulated from the inputs alone, so it is the same.
    #[must_use]
    pub fn again(&self, before: usize, primary: &[f64]) -> Option<Vec<f64>> {
        let bias = self.bias.get(before..)?;
        let same = self.open_from <= before;
        same.then(|| primary.iter().zip(bias).map(|(r, mu)| r - mu).collect())
    }
}

impl Trained {
    /// Judges the same residuals by another detector from now on: nothing is learned again.
    pub fn judge_by(&mut self, detector: DetectorSpec) -> &Self {
        self.spec.detector = detector;
        self
    }

    /// The residual generator alone.
    ///
    /// # Errors
    ///
    /// Returns an error when the design cannot be built.
    pub fn primary(&self) -> Result<Primary, TrainingError> {
        Ok(Primary { generator: self.design().build()?, fork: None })
    }

    /// The compensator alone.
    ///
    /// # Errors
    ///
    /// Returns an error when the bias model cannot be run.
    pub fn subtraction(&self) -> Result<Subtraction, TrainingError> {
        Ok(Subtraction { compensator: self.compensator()?, io: self.design().io() })
    }
}
