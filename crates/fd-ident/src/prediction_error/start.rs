//! Where a search begins: least squares, instrumental variables, and the noise that they leave.

use faer::Mat;

use super::predictor::{Predictor, Stretch};
use crate::{
    arx::reflect,
    error::IdentError,
    least_squares::{Deficient, LeastSquares},
};

/// Coefficients `c` and `d` of `v = C/D e` after Hannan & Rissanen (1982): a long autoregression
/// estimates `e`, a regression on past `v` and `e` estimates `d` and `c`. Zero where the noise
/// does not allow that.
pub(super) fn noise_start(
    noise: &[Vec<f64>],
    nc: usize,
    nd: usize,
) -> Result<(Vec<f64>, Vec<f64>), IdentError> {
    let zero = (vec![0.0; nc], vec![0.0; nd]);
    if nc + nd == 0 {
        return Ok(zero);
    }
    let long = 10.max(2 * (nc + nd));
    let regress = |signals: &[(&[Vec<f64>], usize)]| -> Option<Vec<f64>> {
        let lag = signals.iter().map(|(_, order)| *order).max().unwrap_or(0);
        let (mut rows, mut target) = (Vec::new(), Vec::new());
        for (index, v) in noise.iter().enumerate() {
            for k in lag..v.len() {
                let row: Vec<f64> = signals
                    .iter()
                    .flat_map(|(signal, order)| (1..=*order).map(|i| signal[index][k - i]))
                    .collect();
                if v[k].is_finite() && row.iter().all(|value| value.is_finite()) {
                    rows.push(row);
                    target.push(v[k]);
                }
            }
        }
        let n = rows.first().map_or(0, Vec::len);
        let x = Mat::from_fn(rows.len(), n, |i, j| rows[i][j]);
        let solver = LeastSquares::new().when_deficient(Deficient::MinimumNorm);
        solver.solve(x.as_ref(), &target).ok().map(|fit| fit.coefficients)
    };
    let Some(autoregression) = regress(&[(noise, long)]) else { return Ok(zero) };
    let innovations: Vec<Vec<f64>> = noise
        .iter()
        .map(|v| {
            let predicted = |k: usize| -> f64 {
                autoregression.iter().enumerate().map(|(i, a)| a * v[k - 1 - i]).sum()
            };
            (0..v.len()).map(|k| if k < long { f64::NAN } else { v[k] - predicted(k) }).collect()
        })
        .collect();
    let Some(found) = regress(&[(&innovations, nc), (noise, nd)]) else { return Ok(zero) };
    let (mut c, mut d) = (found[..nc].to_vec(), found[nc..].iter().map(|d| -d).collect::<Vec<_>>());
    reflect(&mut c)?;
    reflect(&mut d)?;
    Ok((c, d))
}

/// What a simulation with parameters `theta` leaves of the bias, NaN where that is missing.
pub(super) fn left_over(
    predictor: &Predictor,
    theta: &[f64],
    stretches: &[Stretch],
) -> Vec<Vec<f64>> {
    // The errors of the output-error predictor are just that.
    let plain = Predictor { noise: super::NoiseStructure::OutputError, ..*predictor };
    let past = vec![0.0; plain.past()];
    stretches
        .iter()
        .map(|stretch| {
            let mut left = Vec::with_capacity(stretch.mu.len());
            plain.run(theta, &past, stretch, false, |error, _| left.push(error));
            let mut left = left.into_iter();
            let at = |mu: &f64| if mu.is_finite() { left.next() } else { None };
            stretch.mu.iter().map(at).map(|v| v.unwrap_or(f64::NAN)).collect()
        })
        .collect()
}
