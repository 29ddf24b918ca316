//! Forecasts without any model, which a model must beat.

use fd_sim::simulate::Simulator;

use super::{forecast::known_until, gap::gap_per_output};
use crate::fit::{FitError, Horizon, Log, Plan};

/// Root mean square errors of forecasts without any model, per output, in the unit of the output; scored
/// where [`forecast_errors`](super::forecast_errors) scores models.
#[derive(Clone, Debug, PartialEq)]
pub struct Baselines {
    /// The mean of the logs that were fitted.
    pub constant: Vec<f64>,
    /// The last measured value before the scored part of each segment.
    pub last_value: Vec<f64>,
}

impl Baselines {
    /// Forecasts `logs` at a horizon by the mean of the `fitted` ones, and by the last value that is known.
    ///
    /// # Errors
    ///
    /// As [`Plan::new`], for the `nominal` simulator.
    pub fn of(
        nominal: &dyn Simulator,
        fitted: &[Log],
        logs: &[Log],
        horizon: Horizon,
    ) -> Result<Self, FitError> {
        let ny = nominal.outputs().len();
        let means: Vec<f64> = (0..ny).map(|c| mean(fitted, c)).collect();
        let mut errors = [vec![Vec::new(); ny], vec![Vec::new(); ny]];
        for log in logs {
            let plan = Plan::of_logs(nominal, vec![log.clone()], horizon)?;
            for segment in plan.segments() {
                let first = known_until(segment, horizon);
                for (c, mean) in means.iter().enumerate() {
                    let value = |k: usize| log.y[k * log.ny + c];
                    let known = (segment.from..first).rev().map(value).find(|v| v.is_finite());
                    let scored = first..segment.to;
                    errors[0][c].push(scored.clone().map(|k| mean - value(k)).collect());
                    let last = known.unwrap_or(*mean);
                    errors[1][c].push(scored.map(|k| last - value(k)).collect());
                }
            }
        }
        let [constant, last_value] = errors.map(|errors| gap_per_output(&errors));
        Ok(Self { constant, last_value })
    }
}

/// Mean of what was measured of an output.
fn mean(logs: &[Log], output: usize) -> f64 {
    let values = || logs.iter().flat_map(|log| log.y.iter().skip(output).step_by(log.ny));
    let (sum, n) =
        values().filter(|v| v.is_finite()).fold((0.0, 0.0_f64), |(sum, n), v| (sum + v, n + 1.0));
    sum / n.max(1.0)
}
