//! Causes that change the distribution of a measurement and leave the simulation as it is.

use fd_effect::{Candidate, Kind, Observation, SiteRef};

use super::{
    gaussian::gaussian,
    jitter::Jitter,
    outliers::Outliers,
    stronger_noise::{Known, StrongerNoise, heavier, stronger, weaken},
};
use crate::{
    diagnose::{prepare::noise::KnownNoise, result::Estimate},
    evidence::NoisePrior,
    fit::Problem,
    quality::interval_log_likelihood,
};

/// A grid above this many times the noise is a matter of the sensor, not of the file.
const COARSE: f64 = 0.5;
/// What it says for a grid that values lie on it at all, as a logarithm of the evidence.
const ON_GRID: f64 = 10.0;

/// Log-likelihood ratio from which wrong samples come in bursts, which is no accident of a sensor.
const BURSTS: f64 = 5.0;

/// A cause of the measurement, and what it makes of the errors of a simulation.
#[derive(Clone, Debug)]
pub(in crate::diagnose) struct MeasurementCause<'a> {
    pub(in crate::diagnose) candidate: &'a Candidate,
    /// Logarithm of the evidence over that of the same errors without the cause.
    pub(in crate::diagnose) gain: f64,
    /// The part of it that any simulation would have.
    pub(in crate::diagnose) given: f64,
    /// Log-likelihood that errors which come in bursts would add for something that explains them.
    pub(in crate::diagnose) bursts: f64,
    /// Errors of the output (in sigma) without what the cause has done to them.
    pub(in crate::diagnose) left: Vec<Vec<f64>>,
    /// Fitted parameters.
    pub(in crate::diagnose) parameters: Vec<Estimate>,
}

impl MeasurementCause<'_> {
    /// Log-likelihood that something unknown in its place could gain over it: wrong samples in bursts
    /// are no accident.
    pub(in crate::diagnose) fn doubt(&self) -> f64 {
        if BURSTS < self.bursts { self.bursts } else { 0.0 }
    }
}

/// What causes of the measurement are weighed by.
#[derive(Clone, Copy, Debug)]
pub(in crate::diagnose) struct Measured<'a> {
    /// Its logs were measured.
    pub(in crate::diagnose) problem: &'a Problem,
    /// Simulated outputs of each log.
    pub(in crate::diagnose) outputs: &'a [Vec<f64>],
    /// Their errors, in sigma.
    pub(in crate::diagnose) errors: &'a [Vec<Vec<f64>>],
}

/// Weighs a cause by the errors of a simulation. `None` when there is nothing of it in
/// the measurement.
pub(in crate::diagnose) fn weigh_measurement<'a>(
    candidate: &'a Candidate,
    Measured { problem, outputs, errors }: Measured<'_>,
    noise: &KnownNoise,
    is_coloured: bool,
) -> Option<MeasurementCause<'a>> {
    let (Kind::Observation(kind), SiteRef::Output(output, _)) = (candidate.kind, &candidate.site)
    else {
        return None;
    };
    let signals = errors.get(*output)?;
    let prior = noise.priors(is_coloured)[*output];
    let sigma = noise.sigma[*output];
    let exact = |value| Known { value, standard_error: 0.0 };
    let (mut bursts, mut left) = (0.0, signals.clone());
    let (gain, given, values) = match kind {
        Observation::Quantised => {
            let step = noise.grids[*output].filter(|step| COARSE * sigma < *step)?;
            (rounded(signals, prior.coloured(false), step / sigma), ON_GRID, vec![exact(step)])
        }
        Observation::Outliers => {
            let found = Outliers::of(signals, prior)?;
            (bursts, left) = (found.bursts, found.without(signals));
            let Outliers { gain, share: value, standard_error, .. } = found;
            (gain, 0.0, vec![Known { value, standard_error }])
        }
        Observation::Jitter => {
            let found = Jitter::of(signals, prior, problem, outputs, *output)?;
            left = found.left;
            (found.gain, 0.0, vec![found.time])
        }
        Observation::Noise | Observation::HeavyTails => {
            noise.stated[*output]?;
            let weigh = if kind == Observation::Noise { stronger } else { heavier };
            let StrongerNoise { gain, extra: Known { value, standard_error }, freedom } =
                weigh(signals, prior)?;
            weaken(&mut left, prior);
            let (value, standard_error) = (sigma * value, sigma * standard_error);
            let extra = Known { value, standard_error };
            (gain, 0.0, std::iter::once(extra).chain(freedom).collect())
        }
    };
    let parameters = candidate.parameters.iter().zip(values).map(|(p, known)| Estimate {
        name: p.name.clone(),
        unit: p.unit.clone(),
        value: known.value,
        standard_error: known.standard_error,
        is_strength: p.is_strength,
        is_reciprocal: p.is_reciprocal,
    });
    let (gain, parameters) = (gain + given, parameters.collect());
    Some(MeasurementCause { candidate, gain, given, bursts, left, parameters })
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
