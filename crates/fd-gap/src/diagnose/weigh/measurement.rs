//! Causes that change the distribution of a measurement and leave the simulation as it is.

use fd_effect::{Candidate, Kind, Observation, SiteRef};

use super::{
    jitter::Jitter,
    outliers::Outliers,
    stronger_noise::{Known, StrongerNoise, heavier, stronger, weaken},
};
use crate::{
    diagnose::{prepare::noise::KnownNoise, result::Estimate},
    evidence::grades::VERY_STRONG,
    fit::Problem,
};

/// A cause of the measurement, and what it makes of the errors of a simulation.
#[derive(Clone, Debug)]
pub(in crate::diagnose) struct MeasurementCause<'a> {
    pub candidate: &'a Candidate,
    /// Logarithm of the evidence over that of the same errors without the cause.
    pub gain: f64,
    /// Log-likelihood that errors which come in bursts would add for something that explains them.
    pub bursts: f64,
    /// Errors of the output (in sigma) without what the cause has done to them.
    pub left: Vec<Vec<f64>>,
    /// Fitted parameters.
    pub parameters: Vec<Estimate>,
}

impl MeasurementCause<'_> {
    /// Log-likelihood that something unknown in its place could gain over it: wrong samples in bursts
    /// are no accident.
    pub(in crate::diagnose) fn doubt(&self) -> f64 {
        if VERY_STRONG < self.bursts { self.bursts } else { 0.0 }
    }
}

/// What causes of the measurement are weighed by.
#[derive(Clone, Copy, Debug)]
pub(in crate::diagnose) struct Measured<'a> {
    /// Its logs were measured.
    pub problem: &'a Problem,
    /// Simulated outputs of each log.
    pub outputs: &'a [Vec<f64>],
    /// Their errors, in sigma.
    pub errors: &'a [Vec<Vec<f64>>],
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
    // Coarse steps are noise of their size to other distributions of errors: as cells a few samples that miss theirs, and
    // with a colour the jumps between steps, would make any of them look good.
    let is_white = noise.is_coarse(*output);
    let prior = noise.priors(is_coloured && !is_white)[*output].of_its_size();
    let sigma = noise.sigma[*output];
    let (mut bursts, mut left) = (0.0, signals.clone());
    let (gain, values) = match kind {
        Observation::Outliers => {
            let found = Outliers::of(signals, prior)?;
            (bursts, left) = (found.bursts, found.without(signals));
            let Outliers { gain, share: value, standard_error, .. } = found;
            (gain, vec![Known { value, standard_error }])
        }
        Observation::Jitter => {
            let found = Jitter::of(signals, prior, problem, outputs, *output)?;
            left = found.left;
            (found.gain, vec![found.time])
        }
        Observation::Noise | Observation::HeavyTails => {
            noise.stated[*output]?;
            let weigh = if kind == Observation::Noise { stronger } else { heavier };
            let StrongerNoise { gain, extra: Known { value, standard_error }, freedom } =
                weigh(signals, prior)?;
            weaken(&mut left, prior);
            let (value, standard_error) = (sigma * value, sigma * standard_error);
            let extra = Known { value, standard_error };
            (gain, std::iter::once(extra).chain(freedom).collect())
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
    Some(MeasurementCause { candidate, gain, bursts, left, parameters: parameters.collect() })
}
