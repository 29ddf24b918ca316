//! From a log to the primary residual, as a record that identification can learn from.

use fd_core::{Frame, stage::ResidualGenerator};
use fd_model::{Channel, Record};

use super::{error::TrainingError, trace::LONGEST_GAP};

/// Runs `generator` over `record` from rest and returns its residual with the inputs.
///
/// The first `settle` samples, in which the generator forgets its initial state, are marked as
/// missing, and so is every sample that is incomplete in the log; there the generator sees the
/// last good values, and settles again after more than [`LONGEST_GAP`] of them.
///
/// # Errors
///
/// Returns an error when the log has other channels than the generator.
pub fn residual_record(
    generator: &mut dyn ResidualGenerator,
    record: &Record,
    settle: usize,
) -> Result<Record, TrainingError> {
    let io = generator.io();
    for (signal, expected, found) in
        [("input", io.nu, record.inputs().len()), ("output", io.ny, record.outputs().len())]
    {
        if expected != found {
            return Err(TrainingError::Channels { signal, expected, found });
        }
    }
    generator.reset();
    let channels = generator.residual_len();
    let (mut u, mut y) = (vec![0.0; io.nu], vec![0.0; io.ny]);
    let mut residual = vec![f64::NAN; record.len() * channels];
    let mut inputs = Vec::with_capacity(record.len() * io.nu);
    let (mut settled, mut gap) = (settle, 0);
    for (k, r) in residual.chunks_exact_mut(channels).enumerate() {
        inputs.extend_from_slice(record.u(k));
        keep_finite(&mut u, record.u(k));
        keep_finite(&mut y, record.y(k));
        let frame = Frame::new(io, k as u64, &u, &y)?;
        generator.step(frame, r);
        if !record.is_complete(k) {
            gap += 1;
        } else if LONGEST_GAP < std::mem::take(&mut gap) {
            settled = k.saturating_add(settle);
        }
        if k < settled || 0 < gap {
            r.fill(f64::NAN);
        }
    }
    let names = Channel::numbered("r", channels);
    let start = record.time(0);
    Ok(Record::new(record.inputs().to_vec(), names, inputs, residual, record.ts())?
        .starting_at(start))
}

/// Mean of each residual channel over the complete samples of all records.
pub(super) fn means(records: &[Record]) -> Vec<f64> {
    let channels = records.first().map_or(0, |record| record.outputs().len());
    let (mut sums, mut count) = (vec![0.0; channels], 0_usize);
    for record in records {
        for k in (0..record.len()).filter(|&k| record.is_complete(k)) {
            sums.iter_mut().zip(record.y(k)).for_each(|(sum, r)| *sum += r);
            count += 1;
        }
    }
    sums.iter().map(|sum| sum / count.max(1) as f64).collect()
}

fn keep_finite(kept: &mut [f64], new: &[f64]) {
    for (kept, &new) in kept.iter_mut().zip(new) {
        if new.is_finite() {
            *kept = new;
        }
    }
}
