//! What the residual of a healthy plant is like.

use fd_core::{Frame, stage::ResidualGenerator};
use fd_model::Record;

use crate::error::NonlinearError;

/// Fewest samples to learn from.
const FEWEST: usize = 50;
/// Autocorrelation below which samples count as independent.
const INDEPENDENT: f64 = 0.05;

/// What is learned of each output.
#[derive(Clone, Debug)]
pub(super) struct Learned {
    /// Standard deviation.
    pub deviation: Vec<f64>,
    /// Variance of a sample as evidence: that of the residual times the samples that are worth one
    /// independent sample.
    pub variance: Vec<f64>,
    /// Largest magnitude of the smoothed residual, in standard deviations.
    pub largest: Vec<f64>,
}

/// Runs the untracked residual over healthy logs.
pub(super) fn learn(
    generator: &mut impl ResidualGenerator,
    healthy: &[Record],
    settle: usize,
    smoothing: f64,
) -> Result<Learned, NonlinearError> {
    let io = generator.io();
    let mut logs = Vec::new();
    for record in healthy {
        let found = record.inputs().len() + record.outputs().len();
        if io.nu != record.inputs().len() || io.ny != record.outputs().len() {
            let (what, expected) = ("channels of a healthy log", io.nu + io.ny);
            return Err(NonlinearError::Length { what, expected, found });
        }
        generator.reset();
        let (mut rows, mut r) = (Vec::new(), vec![0.0; io.ny]);
        for k in 0..record.len() {
            // A sample that is not complete never arrives.
            let Ok(frame) = Frame::new(io, k as u64, record.u(k), record.y(k)) else { continue };
            generator.step(frame, &mut r);
            if settle <= k && r.iter().all(|r| r.is_finite()) {
                rows.push(r.clone());
            }
        }
        logs.push(rows);
    }
    let found = logs.iter().map(Vec::len).sum();
    if found < FEWEST {
        let what = "complete healthy samples to learn from, at least";
        return Err(NonlinearError::Length { what, expected: FEWEST, found });
    }
    let mut learned = Learned { deviation: Vec::new(), variance: Vec::new(), largest: Vec::new() };
    for channel in 0..io.ny {
        let logs: Vec<Vec<f64>> =
            logs.iter().map(|rows| rows.iter().map(|row| row[channel]).collect()).collect();
        let deviation = fd_numeric::rms(logs.iter().flatten().copied());
        // A residual that is nothing but rounding is as good as exact.
        let deviation = deviation.max(f64::MIN_POSITIVE.sqrt());
        let (mut largest, mut worth) = (0.0_f64, 1.0_f64);
        for log in &logs {
            let mut smoothed = 0.0;
            for r in log {
                smoothed += smoothing * (r / deviation - smoothed);
                largest = largest.max(smoothed.abs());
            }
            worth = worth.max(samples_worth_one(log));
        }
        learned.deviation.push(deviation);
        learned.variance.push(deviation * deviation * worth);
        learned.largest.push(largest);
    }
    Ok(learned)
}

/// Samples that are worth one independent sample, `1 + 2 Σ ρ`, up to the lag at which the correlation is gone.
fn samples_worth_one(log: &[f64]) -> f64 {
    let power = fd_numeric::dot(log, log);
    if power <= 0.0 {
        return 1.0;
    }
    let shares = (1..log.len() / 2).map(|lag| fd_numeric::dot(log, &log[lag..]) / power);
    1.0 + 2.0 * shares.take_while(|share| INDEPENDENT < *share).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    #[test]
    fn correlated_samples_are_worth_less() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(4);
        let mut state = 0.0;
        let slow: Vec<f64> = (0..20_000)
            .map(|_| {
                state = 0.9 * state + random.random::<f64>() - 0.5;
                state
            })
            .collect();
        // (1 + 0.9) / (1 − 0.9) = 19, less what is cut off below 0.05, and known to some ten per cent.
        let worth = samples_worth_one(&slow);
        assert!((14.0..22.0).contains(&worth), "{worth}");
        assert!(samples_worth_one(&[0.0; 100]) <= 1.0);
    }
}
