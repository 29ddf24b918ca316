//! Whether there is something to be fitted, and what it is fitted to.

use std::borrow::Borrow;

use fd_model::Record;

use crate::{arx::ArxOrders, error::IdentError};

impl ArxOrders {
    /// Number of parameters, or an error when there are none.
    pub(crate) fn checked_parameters(self, nu: usize) -> Result<usize, IdentError> {
        match self.parameters(nu) {
            0 => Err(IdentError::NoParameters { orders: self, nu }),
            n => Ok(n),
        }
    }
}

/// The first record, when all others have the same channels and sample time.
pub(crate) fn check_records<R: Borrow<Record>>(records: &[R]) -> Result<&Record, IdentError> {
    let first = records.first().ok_or(IdentError::NoRecords)?.borrow();
    let facts = |record: &Record| {
        [
            ("number of inputs", record.inputs().len() as f64),
            ("number of residuals", record.outputs().len() as f64),
            ("sample time in s", record.ts().seconds()),
        ]
    };
    for (index, record) in records.iter().enumerate() {
        for ((what, expected), (_, found)) in facts(first).into_iter().zip(facts(record.borrow())) {
            if (expected - found).abs() > 1e-9 * expected {
                return Err(IdentError::RecordMismatch { record: index, what, expected, found });
            }
        }
    }
    Ok(first)
}

/// A record with one of its outputs.
pub(crate) fn single_output(record: &Record, channel: usize) -> Result<Record, IdentError> {
    let u = (0..record.len()).flat_map(|k| record.u(k).iter().copied()).collect();
    let output = vec![record.outputs()[channel].clone()];
    let y = record.output(channel).collect();
    Ok(Record::new(record.inputs().to_vec(), output, u, y, record.ts())?)
}
