//! The shape of a healthy residual (jumps, drifts, outliers) that the inputs do not explain.

use fd_compensate::calibrate::autocorrelation_time;
use fd_numeric::{dot, robust_deviation};

/// Fewest samples that are looked at.
pub(super) const LEAST: usize = 100;
/// Time constants in samples of the low-passes through which inputs are looked at, besides as they are.
const VIEWS: [f64; 2] = [10.0, 100.0];
/// Standard errors beyond which a jump, of which every place is tried, and a drift are no chance. What is left of
/// slow noise after the best jump seems quicker than it is, so that 6.9 of them were met in 200 healthy logs.
const JUMP: f64 = 8.0;
const DRIFT: f64 = 5.0;
/// Independent samples that are needed on either side of a jump: fewer show no spread to compare it with.
const INDEPENDENT: f64 = 10.0;
/// Least jump or drift that matters, in deviations of what else is there.
const MATTERS: f64 = 1.0;
/// Deviations beyond which a sample is an outlier, and the largest share of samples that can be some.
const FAR: f64 = 10.0;
const FEW: f64 = 0.02;
/// Least part of a jump that the inputs must not explain for it to be told from them.
const OWN: f64 = 0.2;

/// What was found; sizes in the unit of the residual.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Shape {
    /// Sample, size, standard errors.
    pub jump: Option<(usize, f64, f64)>,
    /// Size over the log, standard errors.
    pub drift: Option<(f64, f64)>,
    /// First sample, number of samples, the largest in deviations.
    pub outliers: Option<(usize, usize, f64)>,
}

/// Looks for a jump or a drift, whichever explains more, and for outliers next to it.
pub(super) fn shape(inputs: &[Vec<f64>], e: &[f64]) -> Shape {
    let n = e.len();
    let basis = basis(inputs, n);
    let mut left = e.to_vec();
    remove(&basis, &mut left);
    let trend: Vec<f64> = (0..n).map(|k| (k as f64 + 0.5) / n as f64).collect();
    let jump = best_jump(&basis, &left);
    let drift = along(&basis, &trend, &left);
    let gain = |found: Option<(f64, f64)>| found.map_or(0.0, |(size, own)| size * size * own);
    let is_jump = gain(jump.map(|(_, size, own)| (size, own))) > gain(drift);
    let (shape, found) = match (is_jump, jump) {
        (true, Some((at, size, own))) => {
            let step: Vec<f64> = (0..n).map(|k| f64::from(u8::from(k >= at))).collect();
            (step, Some((size, own)))
        }
        _ => (trend, drift),
    };
    if let Some((size, _)) = found {
        let mut own = shape;
        remove(&basis, &mut own);
        left.iter_mut().zip(own).for_each(|(left, own)| *left -= size * own);
    }
    let power = dot(&left, &left) / n as f64;
    // A residual that does not forget within half of the log is worth a few samples only.
    let time = autocorrelation_time(&left).unwrap_or(n as f64 / 10.0);
    let significant = found.and_then(|(size, own)| {
        let deviations = size.abs() * (own / (power * time)).sqrt();
        let least = if is_jump { JUMP } else { DRIFT };
        let shorter = if is_jump { jump.map_or(0, |(at, ..)| at.min(n - at)) } else { n };
        let is_known = INDEPENDENT * time <= shorter as f64;
        let matters = is_known && size.abs() >= MATTERS * power.sqrt() && deviations >= least;
        matters.then_some((size, deviations))
    });
    let (jump, drift) = match (is_jump, jump) {
        (true, Some((at, ..))) => {
            (significant.map(|(size, deviations)| (at, size, deviations)), None)
        }
        _ => (None, significant),
    };
    Shape { jump, drift, outliers: outliers(&left) }
}

/// Orthonormal columns: a constant, and the inputs as they are and slowed down.
fn basis(inputs: &[Vec<f64>], n: usize) -> Vec<Vec<f64>> {
    let mut columns = vec![vec![1.0; n]];
    for input in inputs {
        columns.push(input.clone());
        for time in VIEWS.into_iter().filter(|time| 10.0 * time <= n as f64) {
            let mut slow = input.first().copied().unwrap_or(0.0);
            let low_passed = input.iter().map(|u| {
                slow += (u - slow) / (1.0 + time);
                slow
            });
            columns.push(low_passed.collect());
        }
    }
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for mut column in columns {
        let before = dot(&column, &column).sqrt();
        // Twice is enough (Kahan and Parlett): what rounding brought back goes in the second round.
        remove(&basis, &mut column);
        remove(&basis, &mut column);
        let length = dot(&column, &column).sqrt();
        if length > 1e-6 * before {
            for value in &mut column {
                *value /= length;
            }
            basis.push(column);
        }
    }
    basis
}

fn remove(basis: &[Vec<f64>], values: &mut [f64]) {
    for column in basis {
        let share = dot(column, values);
        values.iter_mut().zip(column).for_each(|(v, c)| *v -= share * c);
    }
}

/// Size of a shape in what is left, and the sum of squares of what is its own.
fn along(basis: &[Vec<f64>], shape: &[f64], left: &[f64]) -> Option<(f64, f64)> {
    let explained: f64 = basis.iter().map(|column| dot(column, shape).powi(2)).sum();
    let mean = shape.iter().sum::<f64>() / shape.len() as f64;
    let motion: f64 = shape.iter().map(|v| (v - mean) * (v - mean)).sum();
    let own = dot(shape, shape) - explained;
    (own > OWN * motion).then(|| (dot(shape, left) / own, own))
}

/// The place of the jump that explains most, its size, and the sum of squares of what is its own. All places
/// but the ends are tried, with sums from the end on.
fn best_jump(basis: &[Vec<f64>], left: &[f64]) -> Option<(usize, f64, f64)> {
    let n = left.len();
    let edge = n / 20;
    let mut sums = vec![0.0; basis.len()];
    let mut total = 0.0;
    let mut best: Option<(usize, f64, f64)> = None;
    for at in (0..n).rev() {
        sums.iter_mut().zip(basis).for_each(|(sum, column)| *sum += column[at]);
        total += left[at];
        if at < edge || at >= n - edge {
            continue;
        }
        let count = (n - at) as f64;
        let own = count - sums.iter().map(|s| s * s).sum::<f64>();
        let motion = count * at as f64 / n as f64;
        if own <= OWN * motion {
            continue;
        }
        let gain = total * total / own;
        if best.is_none_or(|(_, size, own)| gain > size * size * own) {
            best = Some((at, total / own, own));
        }
    }
    best
}

fn outliers(left: &[f64]) -> Option<(usize, usize, f64)> {
    let deviation = robust_deviation(&mut left.iter().map(|v| v.abs()).collect::<Vec<_>>())?;
    let far = |v: &f64| v.abs() > FAR * deviation;
    let first = left.iter().position(far)?;
    let samples = left.iter().filter(|v| far(v)).count();
    let largest = left.iter().fold(0.0_f64, |m, v| m.max(v.abs())) / deviation;
    let few = samples as f64 <= FEW * left.len() as f64 && deviation > 0.0;
    few.then_some((first, samples, largest))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Uniform numbers between −1 and 1 (Knuth 1997).
    fn noise(seed: u64, n: usize) -> Vec<f64> {
        let mut state = seed;
        let mut next = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        (0..n).map(|_| next()).collect()
    }

    /// Noise that forgets by `pole` per sample, about as large for any pole.
    fn coloured(seed: u64, n: usize, pole: f64) -> Vec<f64> {
        let (mut state, scale) = (0.0, (1.0 - pole * pole).sqrt());
        let slow = noise(seed, n).into_iter().map(|e| {
            state = pole * state + scale * e;
            state
        });
        slow.collect()
    }

    fn steps(n: usize) -> Vec<f64> {
        (0..n).map(|k| if (k / 130) % 2 == 0 { 1.0 } else { -0.6 }).collect()
    }

    /// Of 200 healthy logs none is doubted, white or coloured, and whatever the inputs leave in it.
    #[test]
    fn healthy_residuals_are_not_doubted() {
        let inputs = vec![steps(1500)];
        for seed in 0..200 {
            let pole = [0.0, 0.5, 0.9, 0.97][(seed % 4) as usize];
            let e: Vec<f64> = coloured(seed, 1500, pole)
                .iter()
                .zip(&inputs[0])
                .map(|(e, u)| e + 0.7 * u)
                .collect();
            assert_eq!(shape(&inputs, &e), Shape::default(), "seed {seed}, pole {pole}");
        }
    }

    #[test]
    fn a_jump_is_found_where_it_is() {
        let inputs = vec![steps(1500)];
        for (seed, at) in (0..50).zip((200..).step_by(20)) {
            let mut e = coloured(seed, 1500, 0.5);
            e[at..].iter_mut().for_each(|e| *e -= 1.5);
            let found = shape(&inputs, &e);
            let Some((place, size, deviations)) = found.jump else {
                panic!("seed {seed}: {found:?}")
            };
            assert!(place.abs_diff(at) < 15 && (size + 1.5).abs() < 0.4 && deviations > JUMP);
            assert_eq!((found.drift, found.outliers), (None, None));
        }
    }

    #[test]
    fn a_drift_is_found_and_is_no_jump() {
        let inputs = vec![steps(1500)];
        for seed in 0..50 {
            let e: Vec<f64> = (0..1500_u32)
                .zip(coloured(seed, 1500, 0.5))
                .map(|(k, e)| e + 3.0 * f64::from(k) / 1500.0)
                .collect();
            let found = shape(&inputs, &e);
            assert!(found.jump.is_none(), "{found:?}");
            assert!(found.drift.is_some_and(|(size, _)| (size - 3.0).abs() < 0.6), "{found:?}");
        }
    }

    #[test]
    fn short_faults_are_outliers() {
        let mut e = coloured(3, 1500, 0.5);
        e[700..705].iter_mut().for_each(|e| *e += 30.0);
        let found = shape(&[steps(1500)], &e);
        assert!(
            found.outliers.is_some_and(|(first, samples, _)| first == 700 && samples == 5),
            "{found:?}"
        );
        assert!(found.jump.is_none() && found.drift.is_none(), "{found:?}");
    }

    /// A jump together with the only step of the input may be what the input does.
    #[test]
    fn what_the_inputs_explain_is_not_doubted() {
        let input: Vec<f64> = (0..1000).map(|k| f64::from(u8::from(k >= 500))).collect();
        let e: Vec<f64> = noise(8, 1000).iter().zip(&input).map(|(e, u)| e + 3.0 * u).collect();
        assert_eq!(shape(&[input], &e), Shape::default());
        // A residual of nothing at all is not doubted either.
        assert_eq!(shape(&[], &[0.0; 300]), Shape::default());
    }
}
