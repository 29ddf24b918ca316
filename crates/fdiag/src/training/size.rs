//! How large a sensor fault is, if it is one of this sensor.

use fd_compensate::decide::{Hypothesis, SizedDebounce};
use fd_core::stage::{DecisionRule, Evidence, Phase, Verdict};

use super::{error::TrainingError, trace::Trace, trained::Trained};
use crate::spec::FaultSites;

/// The size that a lasting fault of each output's sensor would have to explain the residual at the
/// end of a trace, in the (scaled) unit of the output; `None` when there is no alarm.
///
/// A scalar residual cannot tell the sensors apart: exactly one of the sizes is then meant to be
/// read, that of the sensor which other evidence points to.
///
/// # Errors
///
/// Returns an error when the residual has no steady response to a sensor.
pub fn sensor_sizes(trained: &Trained, trace: &Trace) -> Result<Option<Vec<f64>>, TrainingError> {
    let signatures = sensor_signatures(trained)?;
    let hypotheses: Vec<Hypothesis> = (1..)
        .zip(signatures)
        .map(|(i, signature)| Hypothesis { name: format!("output {i}"), signature })
        .collect();
    let (spec, channels) = (trained.spec(), trace.channels);
    let mut rule = SizedDebounce::<f64>::new(channels, spec.rule, &hypotheses, &spec.sizing)?;
    let mut alarmed = false;
    for (k, r_star) in trace.compensated.chunks_exact(channels.max(1)).enumerate() {
        let verdict = Verdict { statistic: trace.statistic[k], threshold: trace.threshold[k] };
        let phase = if trace.compensating[k] {
            Phase::Compensating
        } else {
            Phase::Training { samples: 0 }
        };
        let evidence = Evidence { k: k as u64, phase, verdict, r_star };
        alarmed = rule.decide(evidence).is_fault();
    }
    Ok(alarmed.then(|| rule.sizes().to_vec()))
}

/// Steady residual for a fault of size 1 of each output's sensor.
///
/// # Errors
///
/// Returns an error when the generator has no steady response.
pub fn sensor_signatures(trained: &Trained) -> Result<Vec<Vec<f64>>, TrainingError> {
    Ok(FaultSites::Sensors.signatures(trained.design())?)
}
