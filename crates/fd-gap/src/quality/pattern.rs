//! Can a few functions of known signals still predict a residual?

use crate::together::each;
use fd_numeric::wide::dot;

use super::Autoregression;

/// Delays of the signals, in samples.
const DELAYS: [usize; 6] = [0, 1, 2, 4, 8, 16];
/// Most functions that are used together.
const MOST: usize = 4;

/// A signal that residuals may depend on.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// Values in each segment.
    pub values: Vec<Vec<f64>>,
    /// Least delay, in samples, with which it can be a cause of a residual.
    pub earliest: usize,
}

/// By how much the log-likelihood of a residual rises when up to four delayed functions of the
/// `signals` predict it, beyond what chance would do: each costs `½ ln n + ln K` for the choice of
/// one out of `K`. The residual is whitened first, and functions with it, so that noise of any
/// colour is no pattern; a smooth residual of a plant is one of its equation then, as in sparse
/// regression on accelerations (Brunton, Proctor & Kutz 2016).
///
/// Residual and signals are in segments; NaN where nothing was measured. Zero when nothing helps.
///
/// **Causality.** A signal is used from its [earliest](Signal::earliest) delay on. A logged command must not
/// be used at the sample of the residual itself: in a loop it was made from the measurement of that very
/// sample, noise included, and then true noise is a "pattern" of it (38 to 90 nats in simulated loops, 5 at
/// most from a delay of one sample on).
///
/// ```
/// use fd_gap::quality::{Signal, pattern};
///
/// let u: Vec<f64> = (0..300).map(|k| f64::from((k * k) % 17) - 8.0).collect();
/// let noise = |k: usize| ((k * 7919 + 5) % 101) as f64 / 50.0 - 1.0;
/// let before = |k: usize| u[k.saturating_sub(1)];
/// let follows: Vec<f64> = (0..300).map(|k| 0.1 * before(k).abs() + noise(k)).collect();
/// let alone: Vec<f64> = (0..300).map(noise).collect();
/// let signals = [Signal { values: vec![u.clone()], earliest: 1 }];
/// assert!(pattern(&[follows], &signals) > 10.0);
/// assert!(pattern(&[alone], &signals) < 1.0);
/// ```
#[must_use]
pub fn pattern(residual: &[Vec<f64>], signals: &[Signal]) -> f64 {
    let slices: Vec<&[f64]> = residual.iter().map(Vec::as_slice).collect();
    let colour = Autoregression::fit(&slices, Autoregression::HIGHEST_ORDER);
    let mut left = whitened(&colour, residual, residual);
    let n = left.iter().filter(|e| **e != 0.0).count() as f64;
    if n < 50.0 {
        return 0.0;
    }
    let column = |function: Vec<Vec<f64>>| normalised(whitened(&colour, residual, &function));
    let mut columns: Vec<Vec<f64>> =
        each(functions(residual, signals), column).into_iter().flatten().collect();
    let price = 0.5 * n.ln() + (columns.len().max(1) as f64).ln();
    let (mut best, mut total) = (0.0_f64, 0.0);
    for _ in 0..MOST {
        let power = dot(&left, &left);
        let correlations = each(&columns, |c| dot(c, &left).powi(2) / power);
        let Some((at, share)) = correlations
            .into_iter()
            .enumerate()
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .filter(|(_, s)| 0.0 < *s)
        else {
            break;
        };
        total += -0.5 * n * (1.0 - share).max(f64::EPSILON).ln() - price;
        best = best.max(total);
        // Orthogonal to what was used.
        let used = columns.swap_remove(at);
        remove(&used, &mut left);
        let rest = each(columns, |mut column| {
            remove(&used, &mut column);
            // Less is the same function again.
            if dot(&column, &column) < 1e-4 { None } else { normalised(column) }
        });
        columns = rest.into_iter().flatten().collect();
    }
    best
}

/// Takes the part along a unit vector out of a signal.
pub(super) fn remove(unit: &[f64], from: &mut [f64]) {
    let along = dot(unit, from);
    from.iter_mut().zip(unit).for_each(|(f, u)| *f -= along * u);
}

pub(super) fn normalised(mut column: Vec<f64>) -> Option<Vec<f64>> {
    let size = dot(&column, &column).sqrt();
    let is_fine = size.is_finite() && 0.0 < size;
    is_fine.then(|| {
        for v in &mut column {
            *v /= size;
        }
        column
    })
}

/// A signal filtered as the residual is; zero where that was not measured.
fn whitened(colour: &Autoregression, residual: &[Vec<f64>], signal: &[Vec<f64>]) -> Vec<f64> {
    let mut all = Vec::new();
    for (r, s) in residual.iter().zip(signal) {
        let holed: Vec<f64> =
            r.iter().zip(s).map(|(r, s)| if r.is_finite() { *s } else { f64::NAN }).collect();
        let mut white = vec![0.0; holed.len()];
        colour.whiten(&holed, &mut white);
        all.extend(white);
    }
    all
}

/// Functions of the signals, each with several delays; a constant and a ramp.
fn functions(residual: &[Vec<f64>], signals: &[Signal]) -> Vec<Vec<Vec<f64>>> {
    let shape = |f: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
        let segment = |(s, r): (usize, &Vec<f64>)| (0..r.len()).map(|k| f(s, k)).collect();
        residual.iter().enumerate().map(segment).collect()
    };
    let ramp = |s: usize, k: usize| k as f64 / residual[s].len().max(1) as f64 - 0.5;
    let mut all = vec![shape(&|_, _| 1.0), shape(&ramp)];
    for Signal { values: signal, earliest } in signals {
        let finite = signal.iter().flatten().copied().filter(|v| v.is_finite());
        let [mean, deviation] = fd_numeric::mean_and_deviation(finite);
        if deviation <= 1e-9 * mean.abs() || deviation <= 0.0 {
            continue;
        }
        let size = deviation.max(f64::MIN_POSITIVE);
        for delay in DELAYS.into_iter().filter(|delay| earliest <= delay) {
            let value = |s: usize, k: usize| signal[s][k.saturating_sub(delay)] / size;
            let change = |s: usize, k: usize| value(s, k) - value(s, k.saturating_sub(1));
            all.push(shape(&value));
            all.push(shape(&|s, k| value(s, k).abs()));
            all.push(shape(&|s, k| value(s, k).signum()));
            all.push(shape(&|s, k| value(s, k) * value(s, k).abs()));
            all.push(shape(&|s, k| value(s, k).powi(3)));
            all.push(shape(&change));
            all.push(shape(&|s, k| change(s, k).signum()));
            all.push(shape(&|s, k| change(s, k).abs()));
        }
    }
    all
}
