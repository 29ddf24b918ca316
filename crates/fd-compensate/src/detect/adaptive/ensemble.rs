//! A bound over the transfers that perturbed models leave between input and residual.

use std::f64::consts::PI;

use faer::Mat;
use fd_model::{Discrete, StateSpace};

use super::{InputBound, bank::Bands, non_negative::minimise};
use crate::{
    detect::error::{DetectorError, positive},
    rows::SampleRows,
};

/// Points of the frequency grid, evenly spaced on a logarithmic scale; corners of all poles are added.
const POINTS: usize = 160;

/// Lowest frequency of the grid, in rad per sample, next to zero.
const LOWEST: f64 = 1e-4;

/// Gains below this share of the largest are bounded by it: a bound in proportion to the gain of a
/// transmission zero would cost bands and gain nothing.
const LEAST_GAIN: f64 = 0.05;

/// Rounds of re-weighting towards the smallest worst excess (Lawson 1961).
const ROUNDS: usize = 15;

impl InputBound {
    /// The least weights `b`, up to the sharpness of the bands, with
    /// `Σ_l b_ijl |φ_l(ω)| ≥ |G_ij(ω)|` for each of the transfers `G = H_y ΔG` from input to residual, at
    /// all points of a frequency grid that includes the corners of all their poles.
    ///
    /// `noise` is the level `a` of each channel without any input; see [`noise_levels`].
    ///
    /// # Errors
    ///
    /// Returns an error when there is no transfer, they differ in size or are not finite, or a noise level
    /// is not positive.
    pub fn over_ensemble(
        transfers: &[StateSpace<Discrete>],
        bands: Bands,
        noise: &[f64],
    ) -> Result<Self, DetectorError> {
        let Some(first) = transfers.first() else {
            let (parameter, expected) = ("transfers", "at least 1");
            return Err(DetectorError::Parameter { parameter, expected, found: 0.0 });
        };
        let (channels, nu) = (first.ny(), first.nu());
        let omega = grid(transfers)?;
        let basis: Vec<Vec<f64>> = omega.iter().map(|&w| bands.gains(w)).collect();
        let largest = largest_gains(transfers, &omega)?;
        let gains: Vec<f64> =
            largest.iter().flat_map(|curve| over_bound(curve, &basis, bands.count())).collect();
        debug_assert_eq!(gains.len(), channels * nu * bands.count());
        Self::new(bands, nu, noise, &gains)
    }
}

/// Noise level of each channel, from the differences of successive samples, `√(mean (r(k) − r(k−1))² / 2)`
/// (von Neumann 1941): the standard deviation of white noise, whatever slow signal it rides on.
///
/// ```
/// use fd_compensate::{SampleRows, detect::adaptive::noise_levels};
///
/// let ramp_with_noise: Vec<f64> = (0..100).map(|k| f64::from(k % 2)).collect();
/// let levels = noise_levels(SampleRows::new(1, &ramp_with_noise)?)?;
/// assert!((levels[0] - 0.5_f64.sqrt()).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Returns an error when a channel never changes.
pub fn noise_levels(healthy: SampleRows<'_>) -> Result<Vec<f64>, DetectorError> {
    (0..healthy.channels())
        .map(|channel| {
            let values: Vec<f64> = healthy.channel(channel).collect();
            let squares: f64 = values.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum();
            let level = (0.5 * squares / (values.len() as f64 - 1.0).max(1.0)).sqrt();
            positive("noise level", level)
                .map_err(|_| DetectorError::ConstantChannel { channel, samples: values.len() })?;
            Ok(level)
        })
        .collect()
}

/// Zero, a logarithmic grid up to half the sampling frequency, and the corners of all poles, in rad per
/// sample.
fn grid(transfers: &[StateSpace<Discrete>]) -> Result<Vec<f64>, DetectorError> {
    let mut grid = vec![0.0];
    grid.extend((0..=POINTS).map(|k| LOWEST * (PI / LOWEST).powf(k as f64 / POINTS as f64)));
    for transfer in transfers {
        let poles = transfer.poles().map_err(DetectorError::from)?;
        for rate in poles.iter().map(|pole| pole.ln()) {
            grid.extend(
                [rate.norm(), rate.im.abs()].into_iter().filter(|w| (0.0..=PI).contains(w)),
            );
        }
    }
    grid.sort_by(f64::total_cmp);
    grid.dedup();
    Ok(grid)
}

/// The largest gain at each frequency, a curve for each residual channel and input.
fn largest_gains(
    transfers: &[StateSpace<Discrete>],
    omega: &[f64],
) -> Result<Vec<Vec<f64>>, DetectorError> {
    let (channels, nu) = (transfers[0].ny(), transfers[0].nu());
    let mut curves = vec![vec![0.0_f64; omega.len()]; channels * nu];
    for transfer in transfers {
        crate::detect::error::length("transfer outputs", channels, transfer.ny())?;
        crate::detect::error::length("transfer inputs", nu, transfer.nu())?;
        let per_second = transfer.domain().ts.seconds().recip();
        for (at, &w) in omega.iter().enumerate() {
            let response = transfer.frequency_response(w * per_second)?;
            for i in 0..channels {
                for j in 0..nu {
                    let largest = &mut curves[i * nu + j][at];
                    *largest = largest.max(response[(i, j)].norm());
                }
            }
        }
    }
    Ok(curves)
}

/// Weights whose curve lies above `wanted` everywhere, with the smallest worst ratio that the rounds
/// find.
fn over_bound(wanted: &[f64], basis: &[Vec<f64>], count: usize) -> Vec<f64> {
    let peak = wanted.iter().copied().fold(0.0, f64::max);
    if peak <= 0.0 {
        return vec![0.0; count];
    }
    // Relative to the gain wanted, so that every frequency counts alike: the goal is 1 everywhere.
    let rows: Vec<Vec<f64>> = basis
        .iter()
        .zip(wanted)
        .map(|(phi, gain)| phi.iter().map(|p| p / gain.max(LEAST_GAIN * peak)).collect())
        .collect();
    let ratio = |b: &[f64], row: &[f64]| row.iter().zip(b).map(|(p, b)| p * b).sum::<f64>();
    let mut weight = vec![1.0; rows.len()];
    let (mut best, mut least) = (vec![peak; count], f64::INFINITY);
    let mut b = vec![peak; count];
    for _ in 0..ROUNDS {
        let normal = Mat::from_fn(count, count, |l, m| {
            rows.iter().zip(&weight).map(|(row, w)| w * row[l] * row[m]).sum::<f64>()
        });
        let right: Vec<f64> =
            (0..count).map(|l| rows.iter().zip(&weight).map(|(row, w)| w * row[l]).sum()).collect();
        b = minimise(&normal, &right, b);
        let ratios: Vec<f64> = rows.iter().map(|row| ratio(&b, row)).collect();
        let (low, high) = ratios
            .iter()
            .fold((f64::INFINITY, 0.0_f64), |(low, high), &r| (low.min(r), high.max(r)));
        if low > 0.0 && high / low < least {
            least = high / low;
            best = b.iter().map(|b| b / low).collect();
        }
        let total: f64 = weight.iter().zip(&ratios).map(|(w, r)| w * (r - 1.0).abs()).sum::<f64>();
        if total <= 0.0 {
            break;
        }
        for (w, r) in weight.iter_mut().zip(&ratios) {
            // Never quite zero, so that a point that is met in one round can count in the next.
            *w = rows.len() as f64 * *w * (r - 1.0).abs() / total + 1e-6;
        }
    }
    // The quotient above rounds; the bound must not.
    best.iter().map(|b| b * (1.0 + 1e-12)).collect()
}
