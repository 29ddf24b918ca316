//! Errors of forecasts on logs that the fit has not seen.

use std::sync::Arc;

use fd_sim::simulate::Simulator;

use super::{
    another_run::{Paths, in_this_run},
    carried::Carried,
};
use crate::fit::{
    FitError, Horizon, Layout, LeastSquares, Log, Plan, Problem, Search, Segment, Variable,
    Weights, minimise,
};

/// Part of a free run from which its initial state is estimated.
const FREE_RUN_SHARE: usize = 4;
/// Part of a window for the same purpose.
const WINDOW_SHARE: usize = 2;

/// Relative fall of the sum of squares at which the states of a window are settled: errors above the
/// noise need no more.
pub(super) const STATES_SETTLED: f64 = 1e-4;

/// A model with all its parameters settled.
#[derive(Clone, Copy, Debug)]
pub struct Settled<'a> {
    /// The simulator.
    pub simulator: &'a dyn Simulator,
    /// Values of the nuisance parameters, by name.
    pub nuisances: &'a [(String, f64)],
    /// Parameters of the effect, with their values.
    pub effects: &'a [(Variable, f64)],
    /// What is made of paths over time.
    pub paths: Paths,
}

/// Errors of a forecast, and where they are in the logs.
#[derive(Clone, Debug)]
pub(super) struct Forecast {
    /// As [`forecast_errors`] returns them.
    pub errors: Vec<Vec<Vec<f64>>>,
    pub segments: Vec<Segment>,
    pub begin: Begin,
}

/// What tells the states in which a segment begins.
#[derive(Clone, Copy, Debug)]
enum States {
    /// Its first part, so that the rest is forecast.
    FromFirstPart,
    /// The rest: those from which it is explained best.
    FromRest,
}

/// What initial states were estimated from.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Begin {
    /// Sum of squares that the estimate leaves, in sigma.
    pub squares: f64,
    /// Measured values.
    pub samples: usize,
    /// Initial states.
    pub unknowns: usize,
}

impl Forecast {
    /// Mean square of what is forecast, in sigma.
    pub(super) fn mean_square(&self) -> f64 {
        let errors = || self.errors.iter().flatten().flatten().filter(|e| e.is_finite());
        errors().map(|e| e * e).sum::<f64>() / errors().count().max(1) as f64
    }
}

/// Forecast errors (simulated less measured) in units of sigma: per output, one signal per segment,
/// NaN where nothing was measured and in the first part of each segment (half of a window, a
/// quarter of a free run), from which its initial state is estimated. `None` when a simulation
/// diverges.
///
/// # Errors
///
/// As [`Plan::new`], for the `nominal` simulator.
pub fn forecast_errors(
    nominal: &dyn Simulator,
    settled: Settled<'_>,
    logs: &[Log],
    horizon: Horizon,
    sigma: &[f64],
) -> Result<Option<Vec<Vec<Vec<f64>>>>, FitError> {
    Ok(forecast(nominal, settled, logs, horizon, sigma)?.map(|forecast| forecast.errors))
}

/// As [`forecast_errors`], but each segment begins in the states from which what comes after its first part is explained best.
/// What is missed then is missed by the law, and not for a start that nobody knows: a speed that a few samples tell, or a
/// delay line that a simulator does not show.
pub(crate) fn errors_from_best_starts(
    nominal: &dyn Simulator,
    settled: Settled<'_>,
    logs: &[Log],
    horizon: Horizon,
    sigma: &[f64],
) -> Result<Option<Vec<Vec<Vec<f64>>>>, FitError> {
    let each =
        logs.iter().map(|log| run_of(nominal, settled, log, horizon, sigma, States::FromRest));
    Ok(joined(each, sigma.len())?.map(|all| all.errors))
}

/// Log by log: a free run of each log tells what its effects remember.
pub(super) fn forecast(
    nominal: &dyn Simulator,
    settled: Settled<'_>,
    logs: &[Log],
    horizon: Horizon,
    sigma: &[f64],
) -> Result<Option<Forecast>, FitError> {
    let each = logs.iter().map(|log| forecast_one(nominal, settled, log, horizon, sigma));
    joined(each, sigma.len())
}

/// The runs of several logs as one; `None` where one of them diverges.
fn joined(
    each: impl Iterator<Item = Result<Option<Forecast>, FitError>>,
    outputs: usize,
) -> Result<Option<Forecast>, FitError> {
    let (errors, segments) = (vec![Vec::new(); outputs], Vec::new());
    let mut all = Forecast { errors, segments, begin: Begin::default() };
    for (i, one) in each.enumerate() {
        let Some(Forecast { errors, segments, begin }) = one? else { return Ok(None) };
        all.begin.squares += begin.squares;
        all.begin.samples += begin.samples;
        all.begin.unknowns += begin.unknowns;
        all.errors.iter_mut().zip(errors).for_each(|(all, one)| all.extend(one));
        all.segments.extend(segments.iter().map(|segment| Segment { log: i, ..*segment }));
    }
    Ok(Some(all))
}

/// The first sample of a segment that is forecast: what comes before tells the initial state.
pub(super) fn known_until(segment: &Segment, horizon: Horizon) -> usize {
    let share = match horizon {
        Horizon::FreeRun => FREE_RUN_SHARE,
        Horizon::Windows { .. } => WINDOW_SHARE,
    };
    segment.from + (segment.to - segment.from).div_ceil(share)
}

pub(super) fn forecast_one(
    nominal: &dyn Simulator,
    settled: Settled<'_>,
    log: &Log,
    horizon: Horizon,
    sigma: &[f64],
) -> Result<Option<Forecast>, FitError> {
    run_of(nominal, settled, log, horizon, sigma, States::FromFirstPart)
}

/// The first part of each segment: what comes later need not be simulated.
fn first_parts(plan: &Plan, horizon: Horizon) -> Plan {
    let mut first_parts = plan.clone();
    for segment in &mut first_parts.segments {
        let log = &mut first_parts.logs[segment.log];
        let first = known_until(segment, horizon);
        log.y[first * log.ny..segment.to * log.ny].fill(f64::NAN);
        segment.to = first;
    }
    first_parts
}

/// The plan in which the first part of each segment is simulated, and nothing measured there.
fn without_first_parts(plan: &Plan, horizon: Horizon) -> Plan {
    let mut rest = plan.clone();
    for segment in &rest.segments {
        let log = &mut rest.logs[segment.log];
        log.y[segment.from * log.ny..known_until(segment, horizon) * log.ny].fill(f64::NAN);
    }
    rest
}

fn run_of(
    nominal: &dyn Simulator,
    settled: Settled<'_>,
    log: &Log,
    horizon: Horizon,
    sigma: &[f64],
    states: States,
) -> Result<Option<Forecast>, FitError> {
    let mut plan = Plan::of_logs(nominal, vec![log.clone()], horizon)?;
    for variable in &mut plan.shared {
        let known = settled.nuisances.iter().find(|(name, _)| *name == variable.name);
        if let Some((_, value)) = known {
            // A value may come from elsewhere, beyond the box of this plan.
            variable.start = *value;
            variable.low = variable.low.min(*value);
            variable.high = variable.high.max(*value);
        }
    }
    let begun = first_parts(&plan, horizon);
    let values =
        in_this_run(settled, log, &Begun { settled, sigma, whole: &plan, beginning: &begun })?;
    let segments = plan.segments.clone();
    let problem = |plan, simulator: &dyn Simulator| {
        let effects = settled.effects.iter().map(|(variable, _)| variable.clone()).collect();
        let weights = Weights::white(sigma.to_vec());
        Problem::new(Arc::new(plan), simulator.boxed(), effects, weights)
    };
    let telling = match states {
        States::FromFirstPart => begun,
        States::FromRest => without_first_parts(&plan, horizon),
    };
    let (samples, unknowns) = (telling.measured(), telling.own_variables().count());
    let afresh = settled.simulator;
    let mut estimate = problem(telling.clone(), afresh)?;
    let Layout { shared, .. } = *estimate.layout();
    let origin = vec![0.0; estimate.layout().unknowns() - values.len()];
    let z = estimate.place(&origin, &values);
    let search = Search { own_only: true, relative: STATES_SETTLED, ..Search::default() };
    let is_dear = settled.simulator.stand_in().is_some();
    let search = if is_dear { search.of_dear_runs() } else { search };
    let Some(mut begin) = minimise(&mut estimate, &z, None, search) else { return Ok(None) };
    let starts = segments.iter().enumerate();
    let starts: Vec<(Segment, Vec<f64>)> =
        starts.map(|(s, segment)| (*segment, estimate.start_of(s, &begin.z))).collect();
    let theta = estimate.parameters(&begin.z);
    let mut carried = Carried::new(afresh, nominal.initial(), &theta, log, &starts);
    if let Some(memory) = &carried {
        // What was estimated of the plant may not go with what the effect remembers, as across a stiff spring.
        let with_memory = minimise(&mut problem(telling, memory)?, &begin.z, None, search);
        match with_memory.filter(|with_memory| with_memory.cost <= begin.cost) {
            Some(with_memory) => begin = with_memory,
            None => carried = None,
        }
    }
    let simulator = carried.as_ref().map_or(afresh, |carried| carried as &dyn Simulator);
    // What lies at the edge of its box may be rounded into it.
    debug_assert!(
        begin.z[..shared].iter().zip(&z).all(|(a, b)| (a - b).abs() < 1e-9 * (1.0 + b.abs())),
        "only states move"
    );
    let Some(mut errors) = problem(plan, simulator)?.errors(&begin.z) else { return Ok(None) };
    // Without what the estimate pays for states that are far from where the model says.
    let mut squares = 0.0;
    for signals in &mut errors {
        for (signal, segment) in signals.iter_mut().zip(&segments) {
            let known = &mut signal[..known_until(segment, horizon) - segment.from];
            squares += known.iter().filter(|e| e.is_finite()).map(|e| e * e).sum::<f64>();
            known.fill(f64::NAN);
        }
    }
    Ok(Some(Forecast { errors, segments, begin: Begin { squares, samples, unknowns } }))
}

/// A log and its beginning, from which initial states and what belongs to this run are estimated.
pub(super) struct Begun<'a> {
    settled: Settled<'a>,
    sigma: &'a [f64],
    whole: &'a Plan,
    beginning: &'a Plan,
}

impl Begun<'_> {
    /// The problem in which initial states and those parameters of the effects that are free are unknown, to be fitted
    /// to the `whole` log or to its beginning.
    pub(super) fn free(&self, is_free: &[bool], whole: bool) -> Result<Problem, FitError> {
        let mut plan = if whole { self.whole.clone() } else { self.beginning.clone() };
        for variable in &mut plan.shared {
            (variable.low, variable.high) = (variable.start, variable.start);
        }
        let effects = self.settled.effects.iter().zip(is_free).map(|((variable, value), free)| {
            let mut variable = variable.clone();
            if !free {
                (variable.low, variable.high) = (*value, *value);
            }
            variable
        });
        let weights = Weights::white(self.sigma.to_vec());
        Problem::new(Arc::new(plan), self.settled.simulator.boxed(), effects.collect(), weights)
    }
}
