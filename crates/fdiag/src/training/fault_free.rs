//! Fault-free samples as a running diagnosis meets them.

use fd_compensate::{DrivenRows, RowsError, SampleRows};
use fd_model::Record;

use super::trace::Trace;

/// Which residual is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Judged {
    Primary,
    Compensated,
}

/// Samples of both residuals next to their inputs, row by row, in one or more runs.
#[derive(Clone, Debug, Default)]
pub(super) struct FaultFree {
    pub inputs: Vec<f64>,
    pub primary: Vec<f64>,
    pub compensated: Vec<f64>,
    /// The sample at which each run but the first begins.
    pub starts: Vec<usize>,
    pub samples: usize,
}

impl FaultFree {
    pub(super) fn is_empty(&self) -> bool {
        self.samples == 0
    }

    /// Adds the samples that were judged and are complete, as a run of its own.
    pub(super) fn append(
        &mut self,
        record: &Record,
        trace: &Trace,
        among: impl Iterator<Item = usize>,
    ) {
        let start = self.samples;
        for k in among.filter(|&k| k < trace.len()) {
            if trace.compensating[k] && record.is_complete(k) {
                let row = k * trace.channels..(k + 1) * trace.channels;
                self.push(record.u(k), &trace.residual[row.clone()], &trace.compensated[row]);
            }
        }
        self.begun_at(start);
    }

    pub(super) fn push(&mut self, u: &[f64], primary: &[f64], compensated: &[f64]) {
        self.inputs.extend_from_slice(u);
        self.primary.extend_from_slice(primary);
        self.compensated.extend_from_slice(compensated);
        self.samples += 1;
    }

    pub(super) fn begun_at(&mut self, start: usize) {
        if 0 < start && start < self.samples {
            self.starts.push(start);
        }
    }

    pub(super) fn residual(&self, judged: Judged) -> &[f64] {
        match judged {
            Judged::Primary => &self.primary,
            Judged::Compensated => &self.compensated,
        }
    }

    /// A residual of these samples with their inputs; without any input it is by itself.
    pub(super) fn rows<'a>(&'a self, residual: &'a [f64]) -> Result<DrivenRows<'a>, RowsError> {
        let per_sample = |values: usize| values / self.samples.max(1);
        let residuals = SampleRows::new(per_sample(residual.len()), residual)?;
        let rows = if self.inputs.is_empty() {
            DrivenRows::from(residuals)
        } else {
            let inputs = SampleRows::new(per_sample(self.inputs.len()), &self.inputs)?;
            DrivenRows::new(inputs, residuals)?
        };
        rows.in_runs(&self.starts)
    }
}
