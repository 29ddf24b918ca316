//! Gaps on held-out logs, before and after.

use fd_sim::simulate::Simulator;

use crate::{
    diagnose::{
        context::Context,
        result::HeldOut,
        weigh::{answer::Fit, explain::nuisances},
    },
    fit::{FitError, Horizon, Log, Minimum, NullFit, Problem, Variable},
    shrink::{Closed, Settled, closed, forecast_errors, gap_per_output},
};

/// What is known of the noise of each output.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noise<'a> {
    /// What residuals are measured in, in the unit of the output.
    pub(super) sigma: &'a [f64],
    /// Noise floor, in sigma.
    pub(super) floors: &'a [f64],
}

/// The gaps of the nominal, the refitted and the `best` model: one entry per horizon at which nothing
/// diverges.
pub(super) fn held_out_gaps(
    nominal: &Problem,
    null: &NullFit,
    best: Option<&Fit>,
    logs: &[Log],
    Noise { sigma, floors }: Noise<'_>,
    horizons: &[Horizon],
    context: &Context<'_>,
) -> Result<Vec<HeldOut>, FitError> {
    let nominal = nominal.simulator();
    let named = |problem: &Problem, z: &[f64]| -> Vec<(String, f64)> {
        nuisances(problem, z).into_iter().map(|n| (n.name, n.value)).collect()
    };
    let refitted = named(&null.problem, &null.minimum.z);
    let (mut simulator, mut values): (&dyn Simulator, _) = (nominal, refitted.clone());
    let mut effects: Vec<(Variable, f64)> = Vec::new();
    if let Some(Fit { problem, minimum: Minimum { z, .. } }) = best {
        simulator = problem.simulator();
        values = named(problem, z);
        effects = problem.effects().iter().cloned().zip(problem.effect_values(z)).collect();
    }
    let mut all = Vec::new();
    if logs.is_empty() {
        return Ok(all);
    }
    let ts = nominal.ts().seconds();
    let longest = logs.iter().map(Log::samples).max().unwrap_or(0);
    for &horizon in horizons {
        let run = |simulator, nuisances: &[(String, f64)], effects: &[(Variable, f64)]| {
            let settled = Settled { simulator, nuisances, effects };
            forecast_errors(nominal, settled, logs, horizon, sigma)
        };
        let before = run(nominal, &[], &[])?;
        let refit = run(nominal, &refitted, &[])?;
        let after = run(simulator, &values, &effects)?;
        let (Some(before), Some(refit), Some(after)) = (before, refit, after) else { continue };
        let squares = floors.iter().map(|floor| floor * floor);
        let floor = f64::sqrt(squares.sum::<f64>() / floors.len() as f64);
        let physical = |gaps: &[f64]| -> Vec<f64> {
            gaps.iter().zip(sigma).map(|(gap, sigma)| gap * sigma).collect()
        };
        let (replicas, seed) = (context.settings.replicas, context.settings.seed);
        all.push(HeldOut {
            horizon,
            seconds: ts
                * match horizon {
                    Horizon::FreeRun => longest,
                    Horizon::Windows { samples } => samples.min(longest),
                } as f64,
            nominal: physical(&gap_per_output(&before)),
            refit: physical(&gap_per_output(&refit)),
            after: physical(&gap_per_output(&after)),
            floor: physical(floors),
            closed_of_nominal: closed(&before, &after, floor, replicas, seed)
                .map(Closed::between_runs),
            closed_of_refit: closed(&refit, &after, floor, replicas, seed)
                .map(Closed::between_runs),
        });
    }
    Ok(all)
}
