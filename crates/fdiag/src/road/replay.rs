//! The stages of a trained diagnosis one by one, for who sends many complete logs through many of them.

use std::ops::Range;

use fd_compensate::residual_compensation::ResidualCompensator;
use fd_core::{
    Frame, IoDims, Snapshot,
    stage::{Compensator, Phase, ResidualGenerator, Stage},
};
use fd_model::Record;

use super::{error::RoadError, running::RunningBias, structure::DynIdentifier, train::Trained};

/// The residual generator alone.
pub(crate) struct Primary {
    generator: Box<dyn ResidualGenerator>,
    /// After the samples before the fork of the last whole log.
    fork: Option<Snapshot>,
}

impl Primary {
    /// The primary residual of a whole log, from rest. What comes after sample `fork` can be repeated
    /// by [`Primary::again`].
    pub(crate) fn whole(&mut self, record: &Record, fork: usize) -> Result<Vec<f64>, RoadError> {
        self.generator.reset();
        let fork = fork.min(record.len());
        let mut residual = self.run(record, 0..fork)?;
        self.fork = Some(Snapshot::of(&mut self.generator));
        residual.extend(self.run(record, fork..record.len())?);
        Ok(residual)
    }

    /// The primary residual from sample `fork` on of a log that is the last whole one before it.
    pub(crate) fn again(&mut self, record: &Record, fork: usize) -> Result<Vec<f64>, RoadError> {
        let fork = fork.min(record.len());
        let restored = self.fork.as_ref().is_some_and(|f| f.restore(&mut self.generator).is_ok());
        debug_assert!(restored, "a whole log comes first");
        self.run(record, fork..record.len())
    }

    fn run(&mut self, record: &Record, samples: Range<usize>) -> Result<Vec<f64>, RoadError> {
        let (io, channels) = (self.generator.io(), self.generator.residual_len());
        let mut residual = vec![0.0; samples.len() * channels];
        for (k, r) in samples.zip(residual.chunks_exact_mut(channels)) {
            self.generator.step(Frame::new(io, k as u64, record.u(k), record.y(k))?, r);
        }
        Ok(residual)
    }
}

/// The compensator alone.
pub(crate) struct Subtraction {
    compensator: ResidualCompensator<f64, DynIdentifier, RunningBias>,
    io: IoDims,
}

/// What became of a primary residual.
pub(crate) struct Subtracted {
    /// The compensated residual, row by row.
    pub(crate) residual: Vec<f64>,
    /// The bias `μ̂`, row by row.
    bias: Vec<f64>,
    /// First number of the residual from which on the switch was open throughout.
    open_from: usize,
}

impl Subtraction {
    /// The compensated residual of a whole log without missing samples.
    pub(crate) fn of(&mut self, record: &Record, primary: &[f64]) -> Result<Subtracted, RoadError> {
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
    pub(crate) fn again(&self, before: usize, primary: &[f64]) -> Option<Vec<f64>> {
        let bias = self.bias.get(before..)?;
        let same = self.open_from <= before;
        same.then(|| primary.iter().zip(bias).map(|(r, mu)| r - mu).collect())
    }
}

impl Trained {
    /// The residual generator alone.
    pub(crate) fn primary(&self) -> Result<Primary, RoadError> {
        Ok(Primary { generator: self.design().build()?, fork: None })
    }

    /// The compensator alone.
    pub(crate) fn subtraction(&self) -> Result<Subtraction, RoadError> {
        Ok(Subtraction { compensator: self.compensator()?, io: self.design().io() })
    }
}
