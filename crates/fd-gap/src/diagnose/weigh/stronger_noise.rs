//! Noise that is stronger than stated, Gaussian or with heavy tails.

use std::f64::consts::PI;

use super::{
    colour::COLOURED,
    gaussian::{count, gaussian},
};
use crate::{
    evidence::{DECADES, NoisePrior},
    quality::{Autoregression, HeavyTails, heavy_tails},
};

/// Degrees of freedom of heavy tails.
const FREEDOMS: [f64; 4] = [3.0, 4.0, 6.0, 10.0];

/// What stronger noise makes of the errors of an output.
#[derive(Clone, Copy, Debug)]
pub(super) struct StrongerNoise {
    /// Logarithm of the evidence over that of the expected noise.
    pub gain: f64,
    /// What comes on top of the expected noise, in sigma.
    pub extra: Known,
    /// Degrees of freedom, where tails are heavy.
    pub freedom: Option<Known>,
}

/// A number that is known within an error.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    pub value: f64,
    pub standard_error: f64,
}

/// Noise of any size above the stated one.
pub(super) fn stronger(signals: &[Vec<f64>], prior: NoisePrior) -> Option<StrongerNoise> {
    if is_slow(signals, prior) {
        return None;
    }
    let free = NoisePrior { spread: 1e3, ..prior };
    let (free, held) = (gaussian(signals, free), gaussian(signals, prior));
    let scale = *free.scale.first()?;
    let value = extra(scale, prior)?;
    let standard_error = scale * scale / value / (2.0 * count(signals)).sqrt();
    Some(StrongerNoise {
        gain: free.log - held.log + free_size(prior),
        extra: Known { value, standard_error },
        freedom: None,
    })
}

/// What is stronger and slow is another effect, not noise; but noise of the expected size may be slow,
/// with more on top of it that is not.
fn is_slow(signals: &[Vec<f64>], prior: NoisePrior) -> bool {
    let slices: Vec<&[f64]> = signals.iter().map(Vec::as_slice).collect();
    if COLOURED <= Autoregression::fit(&slices, Autoregression::HIGHEST_ORDER).innovation() {
        return false;
    }
    let expected = (prior.centre + prior.spread).exp();
    expected * expected < shared_by_neighbours(signals)
}

/// Mean product of a sample and the next: at least the part of the power that is slow.
fn shared_by_neighbours(signals: &[Vec<f64>]) -> f64 {
    let products = signals.iter().flat_map(|signal| signal.windows(2).map(|w| w[0] * w[1]));
    let (mut sum, mut count) = (0.0, 0.0_f64);
    for product in products.filter(|product| product.is_finite()) {
        sum += product;
        count += 1.0;
    }
    sum / count.max(1.0)
}

/// What comes on top of the expected noise; `None` where there is nothing.
fn extra(scale: f64, prior: NoisePrior) -> Option<f64> {
    let expected = prior.centre.exp();
    (expected < scale).then(|| (scale * scale - expected * expected).sqrt())
}

/// A log-uniform size instead of a log-normal one: the same curvature, another height of the prior.
fn free_size(prior: NoisePrior) -> f64 {
    (prior.spread * (2.0 * PI).sqrt()).ln() - DECADES.ln()
}

/// Noise of any size above the stated one, with heavy tails.
pub(super) fn heavier(signals: &[Vec<f64>], prior: NoisePrior) -> Option<StrongerNoise> {
    if is_slow(signals, prior) {
        return None;
    }
    let held = gaussian(signals, prior).log;
    let errors: Vec<f64> = signals.iter().flatten().copied().filter(|e| e.is_finite()).collect();
    let found: Vec<HeavyTails> =
        FREEDOMS.iter().filter_map(|freedom| heavy_tails(&errors, *freedom)).collect();
    let best = found.iter().max_by(|a, b| a.log.total_cmp(&b.log))?;
    let extra = extra(best.deviation(), prior)?;
    // Each number of degrees of freedom is as likely as the other.
    let weights: Vec<f64> = found.iter().map(|tails| (tails.log - best.log).exp()).collect();
    let total: f64 = weights.iter().sum();
    let mean = |value: &dyn Fn(f64) -> f64| {
        found.iter().zip(&weights).map(|(f, w)| w / total * value(f.freedom)).sum::<f64>()
    };
    let freedom = mean(&|freedom| freedom);
    let spread = mean(&|other| (other - freedom).powi(2)).sqrt();
    let gain = best.log + (total / FREEDOMS.len() as f64).ln() - held + free_size(prior);
    // Fisher's information of ln s is 2ν/(ν + 3) per sample.
    let HeavyTails { freedom: nu, .. } = best;
    let error =
        best.deviation().powi(2) / extra * ((nu + 3.0) / (2.0 * nu * count(signals))).sqrt();
    Some(StrongerNoise {
        gain,
        extra: Known { value: extra, standard_error: error },
        freedom: Some(Known { value: freedom, standard_error: spread }),
    })
}

/// Gives errors the size that is expected.
pub(super) fn weaken(signals: &mut [Vec<f64>], prior: NoisePrior) {
    let squares: f64 = signals.iter().flatten().filter(|e| e.is_finite()).map(|e| e * e).sum();
    let size = (squares / count(signals)).sqrt();
    if 0.0 < size {
        signals.iter_mut().flatten().for_each(|e| *e *= prior.centre.exp() / size);
    }
}
