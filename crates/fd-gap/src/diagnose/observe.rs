//! Causes that change the distribution of a measurement and leave the simulation as it is.

use std::f64::consts::PI;

use super::{prepare::KnownNoise, result::Estimate};
use crate::{
    effect::{Candidate, Kind, Observation, SiteRef},
    evidence::{DECADES, NoisePrior, likelihood},
    quality::{Autoregression, HeavyTails, heavy_tails, interval_log_likelihood, outlier_mixture},
};

/// A grid above this many times the noise is a matter of the sensor, not of the file.
const COARSE: f64 = 0.5;
/// What it says for a grid that values lie on it at all, as a logarithm of the evidence.
const ON_GRID: f64 = 10.0;

/// Highest order of an autoregression of what may be stronger noise …
const HIGHEST_ORDER: usize = 12;
/// … and least innovation with which it is white.
const WHITE: f64 = 0.95;
/// Degrees of freedom of heavy tails.
const FREEDOMS: [f64; 4] = [3.0, 4.0, 6.0, 10.0];

/// What a cause makes of the errors of a simulation.
#[derive(Clone, Debug)]
pub(super) struct Observed {
    /// Logarithm of the evidence over that of the same errors without the cause.
    pub(super) gain: f64,
    /// The part of it that any simulation would have.
    pub(super) given: f64,
    /// Fitted parameters.
    pub(super) parameters: Vec<Estimate>,
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
    let (gain, given, values) = match kind {
        Observation::Quantised => {
            let step = noise.grids[*output].filter(|step| COARSE * sigma < *step)?;
            (rounded(signals, prior.coloured(false), step / sigma), ON_GRID, vec![[step, 0.0]])
        }
        Observation::Outliers => {
            let [gain, share, error] = outliers(signals, prior)?;
            (gain, 0.0, vec![[share, error]])
        }
        Observation::Noise => {
            noise.stated[*output]?;
            let [gain, value, error] = stronger(signals, prior)?;
            (gain, 0.0, vec![[sigma * value, sigma * error]])
        }
        Observation::HeavyTails => {
            noise.stated[*output]?;
            let (gain, [value, error], freedom) = heavier(signals, prior)?;
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
    Some(Observed { gain: gain + given, given, parameters: parameters.collect() })
}

fn count(signals: &[Vec<f64>]) -> f64 {
    signals.iter().flatten().filter(|e| e.is_finite()).count().max(1) as f64
}

/// Log-likelihood of one output, its constant included.
fn gaussian(signals: &[Vec<f64>], prior: NoisePrior) -> crate::evidence::Likelihood {
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

/// A share of the innovations is much wider than the rest: gain, share, its standard error.
fn outliers(signals: &[Vec<f64>], prior: NoisePrior) -> Option<[f64; 3]> {
    let found = gaussian(signals, prior);
    let colour = found.colour.first()?;
    let (mut innovations, mut spreads) = (Vec::new(), 0.0);
    for signal in signals {
        let mut white = vec![0.0; signal.len()];
        colour.whiten(signal, &mut white);
        let measured = white.iter().zip(signal).filter(|(_, e)| e.is_finite());
        innovations.extend(measured.map(|(w, _)| *w));
        spreads += colour.log_spread(signal);
    }
    let mixture = outlier_mixture(&innovations)?;
    let n = innovations.len() as f64;
    let log = mixture.log
        - prior.cost(mixture.scale.ln())
        - spreads
        - 0.5 * colour.order() as f64 * n.ln();
    // A log-uniform share, of which the data tell 1/√(n p); widths on a coarse grid.
    let known = (mixture.share * n).max(1.0).sqrt();
    let occam = 0.5 * (2.0 * PI).ln() - known.ln() - DECADES.ln() - (mixture.widths as f64).ln();
    Some([log - found.log + occam, mixture.share, mixture.share / known])
}

/// Noise of any size above the stated one: gain, what comes on top of it, its standard error.
fn stronger(signals: &[Vec<f64>], prior: NoisePrior) -> Option<[f64; 3]> {
    if is_slow(signals) {
        return None;
    }
    let free = NoisePrior { spread: 1e3, ..prior };
    let (free, held) = (gaussian(signals, free), gaussian(signals, prior));
    let scale = *free.scale.first()?;
    let extra = extra(scale, prior)?;
    let error = scale * scale / extra / (2.0 * count(signals)).sqrt();
    Some([free.log - held.log + free_size(prior), extra, error])
}

/// What is stronger and slow is another effect, not noise.
fn is_slow(signals: &[Vec<f64>]) -> bool {
    let slices: Vec<&[f64]> = signals.iter().map(Vec::as_slice).collect();
    Autoregression::fit(&slices, HIGHEST_ORDER).innovation() < WHITE
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
    if is_slow(signals) {
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
