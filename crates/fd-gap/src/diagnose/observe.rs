//! Causes that change the distribution of a measurement and leave the simulation as it is.

use std::f64::consts::PI;

use fd_effect::{Candidate, Kind, Observation, SiteRef};

use super::{outliers::Outliers, prepare::KnownNoise, result::Estimate};
use crate::{
    evidence::{DECADES, NoisePrior, likelihood},
    quality::{Autoregression, HeavyTails, heavy_tails, interval_log_likelihood},
};

/// A grid above this many times the noise is a matter of the sensor, not of the file.
const COARSE: f64 = 0.5;
/// What it says for a grid that values lie on it at all, as a logarithm of the evidence.
const ON_GRID: f64 = 10.0;

/// Least innovation of an autoregression of what may be stronger noise with which it is white.
const WHITE: f64 = 0.95;
/// Log-likelihood ratio from which wrong samples come in bursts, which is no accident of a sensor.
const BURSTS: f64 = 5.0;
/// Degrees of freedom of heavy tails.
const FREEDOMS: [f64; 4] = [3.0, 4.0, 6.0, 10.0];

/// What a cause makes of the errors of a simulation.
#[derive(Clone, Debug)]
pub(super) struct Observed {
    /// Logarithm of the evidence over that of the same errors without the cause.
    pub(super) gain: f64,
    /// The part of it that any simulation would have.
    pub(super) given: f64,
    /// Log-likelihood that errors which come in bursts would add for something that explains them.
    pub(super) bursts: f64,
    /// Errors of the output (in sigma) without what the cause has done to them.
    pub(super) left: Vec<Vec<f64>>,
    /// Fitted parameters.
    pub(super) parameters: Vec<Estimate>,
}

impl Observed {
    /// Log-likelihood that something unknown in its place could gain over it: wrong samples in bursts
    /// are no accident.
    pub(super) fn doubt(&self) -> f64 {
        if BURSTS < self.bursts { self.bursts } else { 0.0 }
    }
}

/// Weighs a cause by the errors of a simulation (in sigma). `None` when there is nothing of it in
/// the measurement.
pub(super) fn observe(
    candidate: &Candidate,
    errors: &[Vec<Vec<f64>>],
    noise: &KnownNoise,
    is_coloured: bool,
) -> Option<Observed> {
    let (Kind::Observation(kind), SiteRef::Output(output, _)) = (candidate.kind, &candidate.site)
    else {
        return None;
    };
    let signals = errors.get(*output)?;
    let prior = noise.priors(is_coloured)[*output];
    let sigma = noise.sigma[*output];
    let (mut bursts, mut left) = (0.0, signals.clone());
    let (gain, given, values) = match kind {
        Observation::Quantised => {
            let step = noise.grids[*output].filter(|step| COARSE * sigma < *step)?;
            (rounded(signals, prior.coloured(false), step / sigma), ON_GRID, vec![[step, 0.0]])
        }
        Observation::Outliers => {
            let found = Outliers::of(signals, prior)?;
            (bursts, left) = (found.bursts, found.without(signals));
            (found.gain, 0.0, vec![[found.share, found.standard_error]])
        }
        Observation::Noise => {
            noise.stated[*output]?;
            let [gain, value, error] = stronger(signals, prior)?;
            weaken(&mut left, prior);
            (gain, 0.0, vec![[sigma * value, sigma * error]])
        }
        Observation::HeavyTails => {
            noise.stated[*output]?;
            let (gain, [value, error], freedom) = heavier(signals, prior)?;
            weaken(&mut left, prior);
            (gain, 0.0, vec![[sigma * value, sigma * error], freedom])
        }
    };
    let parameters = candidate.parameters.iter().zip(values).map(|(p, [value, error])| Estimate {
        name: p.name.clone(),
        unit: p.unit.clone(),
        value,
        standard_error: error,
        is_strength: p.is_strength,
        is_reciprocal: p.is_reciprocal,
    });
    Some(Observed { gain: gain + given, given, bursts, left, parameters: parameters.collect() })
}

/// Errors of the size that is expected.
fn weaken(signals: &mut [Vec<f64>], prior: NoisePrior) {
    let squares: f64 = signals.iter().flatten().filter(|e| e.is_finite()).map(|e| e * e).sum();
    let size = (squares / count(signals)).sqrt();
    if 0.0 < size {
        signals.iter_mut().flatten().for_each(|e| *e *= prior.centre.exp() / size);
    }
}

pub(super) fn count(signals: &[Vec<f64>]) -> f64 {
    signals.iter().flatten().filter(|e| e.is_finite()).count().max(1) as f64
}

/// Log-likelihood of one output, its constant included.
pub(super) fn gaussian(signals: &[Vec<f64>], prior: NoisePrior) -> crate::evidence::Likelihood {
    let mut found = likelihood(&[signals.to_vec()], &[prior]);
    found.log -= 0.5 * count(signals) * (2.0 * PI).ln();
    found
}

/// Rounded to a grid of known step (in sigma) after the noise came in: the probability of the cell
/// that a value lies in, against the density of the same noise without rounding.
fn rounded(signals: &[Vec<f64>], prior: NoisePrior, step: f64) -> f64 {
    let errors: Vec<f64> = signals.iter().flatten().copied().filter(|e| e.is_finite()).collect();
    let log = |log_scale: f64| {
        interval_log_likelihood(&errors, log_scale.exp(), step) - prior.cost(log_scale)
    };
    maximum(log, prior.centre - 3.0, prior.centre + 3.0) - gaussian(signals, prior).log
}

/// The largest value of a function with one hill, by golden sections.
fn maximum(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let golden = 0.5 * (f64::sqrt(5.0) - 1.0);
    let mut inner = [high - golden * (high - low), low + golden * (high - low)];
    let mut values = inner.map(&f);
    for _ in 0..40 {
        if values[0] < values[1] {
            low = inner[0];
            inner = [inner[1], low + golden * (high - low)];
            values = [values[1], f(inner[1])];
        } else {
            high = inner[1];
            inner = [high - golden * (high - low), inner[0]];
            values = [f(inner[0]), values[0]];
        }
    }
    values[0].max(values[1])
}

/// Noise of any size above the stated one: gain, what comes on top of it, its standard error.
fn stronger(signals: &[Vec<f64>], prior: NoisePrior) -> Option<[f64; 3]> {
    if is_slow(signals, prior) {
        return None;
    }
    let free = NoisePrior { spread: 1e3, ..prior };
    let (free, held) = (gaussian(signals, free), gaussian(signals, prior));
    let scale = *free.scale.first()?;
    let extra = extra(scale, prior)?;
    let error = scale * scale / extra / (2.0 * count(signals)).sqrt();
    Some([free.log - held.log + free_size(prior), extra, error])
}

/// What is stronger and slow is another effect, not noise; but noise of the expected size may be slow,
/// with more on top of it that is not.
fn is_slow(signals: &[Vec<f64>], prior: NoisePrior) -> bool {
    let slices: Vec<&[f64]> = signals.iter().map(Vec::as_slice).collect();
    if WHITE <= Autoregression::fit(&slices, Autoregression::HIGHEST_ORDER).innovation() {
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

/// Noise of any size above the stated one, with heavy tails: gain, what comes on top of the stated
/// noise and degrees of freedom, both with standard errors.
fn heavier(signals: &[Vec<f64>], prior: NoisePrior) -> Option<(f64, [f64; 2], [f64; 2])> {
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
    Some((gain, [extra, error], [freedom, spread]))
}
