//! Do the inputs move in as many ways as there are parameters?

use faer::Mat;
use fd_model::Record;
use fd_numeric::dense::DenseReal;

use super::doubt::Doubt;
use crate::training::{healthy::Healthy, trained::Trained};

/// Least singular value of the lagged input, relative to the largest, that counts as a way to move.
const LEAST: f64 = 1e-2;
/// Most lags that are looked at.
const MOST: usize = 12;

/// Doubts about the samples that the bias is learned from, all logs together.
///
/// An equation of order `n` has `2 n + 1` parameters per input, and needs an input that is persistently
/// exciting of that order (Ljung 1999, section 13.2): so many copies of it, each later than the one before by
/// a quarter of the slowest time constant of the bias, must be linearly independent.
pub(super) fn excitation(trained: &Trained, healthy: &[Healthy<'_>]) -> Vec<Doubt> {
    let bias = trained.bias_model();
    let needed = (2 * bias.memory() + 1).min(MOST);
    let radii = bias.pole_radii().unwrap_or_default();
    let slowest = radii.into_iter().flatten().fold(0.0, f64::max);
    let samples = if slowest > 0.0 && slowest < 1.0 { -slowest.ln().recip() / 4.0 } else { 1.0 };
    // A time constant beyond the log says nothing about lags; a twentieth of it is as far as it goes.
    let longest = healthy.iter().map(|log| log.learn.len()).max().unwrap_or(0);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "at least 1, bounded"
    )]
    let lag = (samples.round().clamp(1.0, 1e6) as usize).min((longest / 20 / needed).max(1));
    let inputs = trained.design().io().nu;
    (0..inputs).filter_map(|input| doubt(healthy, input, lag, needed)).collect()
}

/// Whether any input moves at all.
#[must_use]
pub fn inputs_move(record: &Record) -> bool {
    (0..record.inputs().len()).any(|channel| {
        let mut values = record.input(channel).filter(|v| v.is_finite());
        let first = values.next();
        values.any(|v| first.is_some_and(|first| (v - first).abs() > 0.0))
    })
}

fn doubt(healthy: &[Healthy<'_>], input: usize, lag: usize, needed: usize) -> Option<Doubt> {
    let stretches: Vec<Vec<f64>> = healthy
        .iter()
        .map(|log| {
            log.learn.clone().filter(|&k| k < log.record.len()).map(|k| log.record.u(k)[input])
        })
        .map(Iterator::collect)
        .collect();
    let finite = || stretches.iter().flatten().copied().filter(|v| v.is_finite());
    let count = finite().count();
    if count == 0 {
        return None;
    }
    let mean = finite().sum::<f64>() / count as f64;
    let (low, high) = finite().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
    // Rounding of a constant is no motion.
    if high - low <= 1e-12 * high.abs().max(low.abs()) {
        return Some(Doubt::StillInput { input });
    }
    let mut gram = Mat::<f64>::zeros(needed, needed);
    for stretch in &stretches {
        for k in (needed - 1) * lag..stretch.len() {
            let past: Vec<f64> = (0..needed).map(|i| stretch[k - i * lag] - mean).collect();
            if past.iter().all(|v| v.is_finite()) {
                for (i, a) in past.iter().enumerate() {
                    for (j, b) in past.iter().enumerate() {
                        gram[(i, j)] += a * b;
                    }
                }
            }
        }
    }
    let ways = independent(&gram);
    (ways < needed).then_some(Doubt::LittleExcitation { input, ways, needed })
}

/// Number of eigenvalues, squares of singular values, that count.
fn independent(gram: &Mat<f64>) -> usize {
    let Ok(values) = gram.symmetric_eigenvalues() else { return 0 };
    let largest = values.iter().fold(0.0_f64, |m, &v| m.max(v));
    values.iter().filter(|&&v| v > LEAST * LEAST * largest).count()
}

#[cfg(test)]
mod tests {
    use fd_model::{Channel, Record, SampleTime};

    use super::*;

    fn ways(u: impl Fn(f64) -> f64) -> Option<Doubt> {
        let samples = 1200;
        let u = (0..samples).map(|k| u(f64::from(k))).collect();
        let (inputs, outputs) = (Channel::numbered("u", 1), Channel::numbered("y", 1));
        let ts = SampleTime::new(1.0).unwrap();
        let record = Record::new(inputs, outputs, u, vec![0.0; 1200], ts).unwrap();
        doubt(&[Healthy::learn(&record)], 0, 3, 5)
    }

    #[test]
    fn ways_of_known_inputs() {
        assert_eq!(ways(|_| 0.3), Some(Doubt::StillInput { input: 0 }));
        let two = Some(Doubt::LittleExcitation { input: 0, ways: 2, needed: 5 });
        assert_eq!(ways(|k| (0.2 * k).sin()), two, "a sinusoid has two");
        assert_eq!(ways(|k| (0.2 * k).sin() + (0.45 * k).sin() + (0.9 * k).sin()), None);
        assert_eq!(ways(|k| f64::from(u8::from(k >= 600.0))), None, "a step has all");
        assert_eq!(ways(|k| k), two, "copies of a ramp are a ramp and a constant");
    }
}
