//! Slower records from faster ones.

use fd_model::{Channel, Record, SampleTime};

use crate::{error::IdentError, rls::positive};

/// Averages blocks of `factor` samples of all channels.
///
/// The time of a block is that of its first sample. A channel that is missing anywhere in a
/// block is missing in its average; a rest that does not fill a block is dropped. For inputs
/// that are constant over a block (held by a zero-order hold) and slow dynamics the averages
/// obey nearly a difference equation of the same order.
///
/// # Errors
///
/// Returns an error when `factor` is zero.
///
/// # Examples
///
/// ```
/// use fd_ident::refine::decimate;
/// use fd_model::{Channel, Record, SampleTime};
///
/// let (u, y) = (vec![1.0, 3.0, 5.0], vec![0.0, 1.0, 2.0]);
/// let ts = SampleTime::new(0.1)?;
/// let record = Record::new(Channel::numbered("u", 1), Channel::numbered("y", 1), u, y, ts)?;
/// let slow = decimate(&record, 2)?;
/// assert_eq!((slow.len(), slow.u(0), slow.y(0)), (1, &[2.0][..], &[0.5][..]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn decimate(record: &Record, factor: usize) -> Result<Record, IdentError> {
    positive("decimation factor", factor as f64)?;
    let blocks = record.len() / factor;
    let average = |channels: &[Channel], sample: &dyn Fn(usize) -> Vec<f64>| -> Vec<f64> {
        let mut averages = vec![0.0; blocks * channels.len()];
        for k in 0..blocks * factor {
            let start = k / factor * channels.len();
            for (sum, value) in averages[start..].iter_mut().zip(sample(k)) {
                *sum += value / factor as f64;
            }
        }
        averages
    };
    let u = average(record.inputs(), &|k| record.u(k).to_vec());
    let y = average(record.outputs(), &|k| record.y(k).to_vec());
    let ts = SampleTime::new(record.ts().seconds() * factor as f64)?;
    let (inputs, outputs) = (record.inputs().to_vec(), record.outputs().to_vec());
    Ok(Record::new(inputs, outputs, u, y, ts)?.starting_at(record.time(0)))
}
