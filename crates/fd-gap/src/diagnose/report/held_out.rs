//! Gaps on held-out logs, before and after.

use crate::together::each;

use crate::{
    diagnose::{
        context::Context,
        result::HeldOut,
        weigh::{answer::Fit, values::FittedValues},
    },
    fit::{FitError, Horizon, Log, NullFit, Problem},
    shrink::{Baselines, Closed, Paths, Settled, closed, forecast_errors, gap_per_output},
};

/// What is known of the noise of each output.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noise<'a> {
    /// What residuals are measured in, in the unit of the output.
    pub sigma: &'a [f64],
    /// Noise floor, in sigma.
    pub floors: &'a [f64],
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
    let as_it_came =
        Settled { simulator: nominal, nuisances: &[], effects: &[], paths: Paths::AsFitted };
    let refit = FittedValues::of(&null.problem, &null.minimum).on(nominal);
    let paths = best.map_or(Paths::AsFitted, Fit::paths);
    let best =
        best.map(|Fit { problem, minimum }| FittedValues::of(problem, minimum).with_paths(paths));
    let best = best.as_ref().unwrap_or(&refit);
    if logs.is_empty() {
        return Ok(Vec::new());
    }
    let ts = nominal.ts().seconds();
    let longest = logs.iter().map(|log| log.samples() - log.lead()).max().unwrap_or(0);
    // Where runs are dear, all of them are made at the same time.
    let run = |settled, horizon| forecast_errors(nominal, settled, logs, horizon, sigma);
    let models = [as_it_came, refit.settled(), best.settled()];
    let of_models = |&horizon: &_| -> Result<Vec<_>, _> {
        each(models, |settled| run(settled, horizon)).into_iter().collect()
    };
    let forecasts: Vec<_> = each(horizons, of_models).into_iter().collect::<Result<_, _>>()?;
    let mut all = Vec::new();
    for (&horizon, forecasts) in horizons.iter().zip(forecasts) {
        let Ok([Some(before), Some(refit), Some(after)]) = <[_; 3]>::try_from(forecasts) else {
            continue;
        };
        // An output that nobody has measured has no part in the gap.
        let is_measured = |of: &Vec<Vec<f64>>| of.iter().flatten().any(|error| error.is_finite());
        let measured = floors.iter().zip(&after).filter(|(_, of)| is_measured(of));
        let floor = fd_numeric::rms(measured.map(|(floor, _)| *floor));
        let physical = |gaps: &[f64]| -> Vec<f64> {
            gaps.iter().zip(sigma).map(|(gap, sigma)| gap * sigma).collect()
        };
        let first = &logs[0];
        let of_first = |errors: &[Vec<Vec<f64>>]| -> Vec<Vec<f64>> {
            let outputs = errors.iter().zip(sigma);
            let of_output = |(signals, sigma): (&Vec<Vec<f64>>, &f64)| {
                let all = signals.iter().flatten().take(first.samples()).skip(first.lead());
                all.map(|error| error * sigma).collect()
            };
            outputs.map(of_output).collect()
        };
        let baselines = Baselines::of(nominal, &null.problem.plan().logs, logs, horizon)?;
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
            constant: baselines.constant,
            last_value: baselines.last_value,
            floor: physical(floors),
            closed_of_nominal: closed(&before, &after, floor, replicas, seed)
                .map(Closed::between_runs),
            closed_of_refit: closed(&refit, &after, floor, replicas, seed)
                .map(Closed::between_runs),
            is_redrawn: paths == Paths::Anew,
            errors: [of_first(&before), of_first(&after)],
        });
    }
    Ok(all)
}
