//! How much of a gap a black-box compensation could remove, whatever its cause.
//!
//! The residual of the refitted model in free run is learned from the training logs, as a linear
//! difference equation of the inputs (the bias model of Patton & Chen 1992, eq. 14) and as a small
//! nonlinear one of inputs and simulated states and outputs, and subtracted from the residual of held-out logs,
//! both in free run: no measured residual of the held-out logs is used. Orders are chosen on the
//! last third of the training logs.
//!
//! It measures how much structure is left, and never competes with physical causes inside a fit. *When not to
//! use:* as a model; it holds only in the region in which it was trained.

mod features;
mod result;

use crate::together::each;
use fd_ident::{
    arx::{ArxFit, ArxModel, ArxOrders, Projection, Start as ArxStart},
    least_squares::{Deficient, LeastSquares},
    refine::Sriv,
};
use fd_model::{Channel, Record};
use fd_sim::simulate::{Outcome, Simulator, walk};

use self::features::{Example, Network, Regression};
pub use self::result::{Ceiling, Compensation};
use crate::{
    diagnose::{Case, Diagnosis, Monitor, Settings, Stage},
    fit::{FitError, Horizon, Log},
    shrink::{Paths, Settled, closed, forecast_errors, gap_per_output},
};

/// Orders `[na, nb]` of the linear equation that are tried, by least squares …
const LINEAR: [[usize; 2]; 7] = [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [0, 20], [0, 60]];
/// … and, with instruments against the noise, by [`Sriv`].
const REFINED: [[usize; 2]; 4] = [[1, 2], [2, 3], [3, 4], [4, 5]];
/// Rounds of the refinement.
const ROUNDS: usize = 10;
/// Past residuals and ridges of the nonlinear one.
const FEEDBACKS: [usize; 2] = [0, 2];
const RIDGES: [f64; 3] = [1e-1, 1e-2, 1e-4];
/// Radius that unstable poles are moved to.
const RADIUS: f64 = 0.98;

/// A log with the residual of the refitted model.
struct Trained {
    log: Log,
    /// Simulated states and outputs of the refitted model, column by column.
    simulated: Vec<Vec<f64>>,
    /// Measured less simulated, in sigma, output by output; NaN in the first quarter, from which
    /// the initial state was estimated.
    residual: Vec<Vec<f64>>,
}

/// Learns compensations from the training logs and scores them on the held-out ones; `None` without
/// held-out logs, or when a simulation diverges. The monitor sees [`Stage::Ceiling`].
///
/// ```
/// use fd_effect::Candidate;
/// use fd_gap::{diagnose::{Case, Settings, diagnose}, ceiling::ceiling};
/// use fd_sim::model::Model;
/// # use fd_model::{Channel, Record};
/// # let model: Model = r#"
/// # version = 1
/// # kind = "equations"
/// # name = "lag"
/// # sample_time = 0.1
/// # inputs = { u = { unit = "V" } }
/// # outputs = { y = { unit = "V", value = "x", noise = 0.01 } }
/// # parameters = { T = { unit = "s", value = 1.0 } }
/// # states = { x = { unit = "V", initial = 0.0, derivative = "(u - x)/T" } }
/// # "#.parse()?;
/// # let (u, y) = ([Channel::new("u", "V")], [Channel::new("y", "V")]);
/// # let noise = |k: u32| 0.01 * f64::from(k * 7919 % 13).sin();
/// # let x = |k: u32| 1.0 - (-0.1 * f64::from(k)).exp();
/// # let rows = (0..100).map(|k| ([1.0], [x(k) + noise(k)]));
/// # let log = Record::from_rows(u.to_vec(), y.to_vec(), rows, model.sample_time()?)?;
/// let (logs, held_out) = ([log.clone()], [log]);
/// let suspects: Vec<Candidate> = Vec::new();
/// let case = Case { nominal: &model, suspects: &suspects, logs: &logs, held_out: &held_out };
/// let settings = Settings::default();
/// let diagnosis = diagnose(&case, &settings, &())?;
/// let found = ceiling(&case, &diagnosis, &settings, &())?.unwrap();
/// assert!(found.nonlinear.is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Returns an error when the model cannot be simulated or does not fit the logs of the case.
pub fn ceiling(
    case: &Case<'_>,
    diagnosis: &Diagnosis,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Option<Ceiling>, FitError> {
    monitor.begin(Stage::Ceiling, 3);
    let ts = case.logs.first().ok_or(FitError::NoLog)?.ts();
    let nominal = case.nominal.simulator(ts)?;
    let mut refit = case.nominal.patched(&diagnosis.refit.model, ts)?;
    let mut prepare = |records: &[Record], earlier: &[Record]| {
        prepare(&*nominal, &mut *refit, records, earlier, diagnosis)
    };
    if case.held_out.is_empty() {
        return Ok(None);
    }
    let (training, held_out) = (prepare(case.logs, &[])?, prepare(case.held_out, case.logs)?);
    let (Some(training), Some(held_out)) = (training, held_out) else { return Ok(None) };
    let outputs = nominal.outputs();
    let floor = diagnosis.floor.iter().map(|f| f * f).sum::<f64>() / outputs.len() as f64;
    let score = |orders: [usize; 2],
                 bias: &(dyn Fn(&Trained, usize) -> Option<Vec<f64>> + Sync)| {
        let errors = |compensated: bool| -> Option<Vec<Vec<Vec<f64>>>> {
            let of_output = |c: usize| {
                let of_log = |log: &Trained| {
                    let bias = bias(log, c).filter(|_| compensated);
                    let bias = bias.unwrap_or_else(|| vec![0.0; log.residual[c].len()]);
                    log.residual[c].iter().zip(bias).map(|(r, b)| b - r).collect()
                };
                held_out.iter().map(of_log).collect()
            };
            Some(each(0..outputs.len(), of_output))
        };
        let (before, after) = (errors(false)?, errors(true)?);
        let physical = gap_per_output(&after).into_iter().zip(&diagnosis.sigma);
        Some(Compensation {
            orders,
            after: physical.map(|(gap, sigma)| gap * sigma).collect(),
            closed: closed(&before, &after, floor.sqrt(), settings.replicas, settings.seed),
        })
    };
    monitor.advance();
    let linear = linear(&training, outputs.len(), ts).and_then(|(orders, models)| {
        score(orders, &|log, c| simulate_linear(&models[c], log, c, ts))
    });
    monitor.advance();
    let nonlinear = nonlinear(&training, outputs.len(), settings.seed)
        .and_then(|(na, networks)| score([na, 33], &|log, c| Some(networks[c].run(&drivers(log)))));
    monitor.advance();
    let mut ceiling = Ceiling { linear, nonlinear, statement: String::new() };
    ceiling.statement = words(&ceiling);
    Ok(Some(ceiling))
}

/// Logs with the residuals of the refitted model in free run.
fn prepare(
    nominal: &dyn Simulator,
    refit: &mut dyn Simulator,
    records: &[Record],
    earlier: &[Record],
    diagnosis: &Diagnosis,
) -> Result<Option<Vec<Trained>>, FitError> {
    let logs = Log::all(records, nominal, earlier)?;
    let nuisances: Vec<(String, f64)> =
        diagnosis.refit.nuisances.iter().map(|n| (n.name.clone(), n.value)).collect();
    let settled =
        Settled { simulator: &*refit, nuisances: &nuisances, effects: &[], paths: Paths::AsFitted };
    let sigma = &diagnosis.sigma;
    let errors = forecast_errors(nominal, settled, &logs, Horizon::FreeRun, sigma)?;
    let Some(errors) = errors else { return Ok(None) };
    let theta = crate::locate::bench::settled(refit);
    let x0: Vec<f64> = refit.initial().iter().map(|state| state.value).collect();
    let mut all = Vec::new();
    for (l, log) in logs.into_iter().enumerate() {
        let mut simulated: Vec<Vec<f64>> = vec![Vec::new(); x0.len() + log.ny];
        let (states, outputs) = simulated.split_at_mut(x0.len());
        let note =
            |_, now: &[f64]| states.iter_mut().zip(now).for_each(|(column, x)| column.push(*x));
        let mut y = vec![0.0; log.samples * log.ny];
        let end = walk(refit, &theta, &x0, log.first as u64, &log.u, &mut y, note);
        for y in y.chunks_exact(log.ny) {
            outputs.iter_mut().zip(y).for_each(|(column, y)| column.push(*y));
        }
        if end != Outcome::Complete || simulated.iter().flatten().any(|v| !v.is_finite()) {
            return Ok(None);
        }
        let residual = errors.iter().map(|e| e[l].iter().map(|v| -v).collect()).collect();
        all.push(Trained { log, simulated, residual });
    }
    Ok(Some(all))
}

/// Inputs, simulated states and outputs.
fn drivers(log: &Trained) -> Vec<Vec<f64>> {
    let input = |i: usize| log.log.u.iter().skip(i).step_by(log.log.nu).copied().collect();
    (0..log.log.nu).map(input).chain(log.simulated.iter().cloned()).collect()
}

/// The residual with NaN before or after two thirds of what is known of it.
fn part(residual: &[f64], is_first: bool) -> Vec<f64> {
    let known: Vec<usize> = (0..residual.len()).filter(|&k| residual[k].is_finite()).collect();
    let limit = known.get(2 * known.len() / 3).copied().unwrap_or(0);
    let value = |(k, r): (usize, &f64)| if (k < limit) == is_first { *r } else { f64::NAN };
    residual.iter().enumerate().map(value).collect()
}

fn mean_square(residual: &[f64], bias: &[f64]) -> [f64; 2] {
    let pairs = residual.iter().zip(bias).filter(|(r, _)| r.is_finite());
    pairs.fold([0.0; 2], |[sum, n], (r, b)| [sum + (r - b).powi(2), n + 1.0])
}

fn record(log: &Trained, residual: Vec<f64>, ts: fd_model::SampleTime) -> Option<Record> {
    let (inputs, outputs) = (Channel::numbered("u", log.log.nu), Channel::numbered("r", 1));
    Record::new(inputs, outputs, log.log.u.clone(), residual, ts).ok()
}

/// Orders and method of a linear equation.
#[derive(Clone, Copy, Debug)]
struct Kind {
    orders: [usize; 2],
    is_refined: bool,
}

fn fit_linear(records: &[Record], kind: Kind) -> Option<ArxModel> {
    let [na, nb] = kind.orders;
    let orders = ArxOrders::new(na, nb, 0).with_offset();
    let model = if kind.is_refined {
        Sriv::new(orders).with_rounds(ROUNDS).fit(records).ok()?.estimate.model
    } else {
        let solver = LeastSquares::new().when_deficient(Deficient::MinimumNorm);
        ArxFit::new(orders).with_solver(solver).fit(records).ok()?.model
    };
    Some(model.projected(Projection::Shrink, RADIUS).ok()?.0)
}

fn simulate_linear(
    model: &ArxModel,
    log: &Trained,
    c: usize,
    ts: fd_model::SampleTime,
) -> Option<Vec<f64>> {
    let simulated =
        model.simulate_record(&record(log, log.residual[c].clone(), ts)?, ArxStart::Rest);
    simulated.ok().filter(|values| values.iter().all(|v| v.is_finite()))
}

/// A linear equation per output, of the orders that forecast the last third of the training best.
fn linear(
    training: &[Trained],
    ny: usize,
    ts: fd_model::SampleTime,
) -> Option<([usize; 2], Vec<ArxModel>)> {
    let fit = |kind: Kind, residual: &(dyn Fn(&Trained, usize) -> Vec<f64> + Sync)| {
        let of_output = |c: usize| {
            let records: Option<Vec<Record>> =
                training.iter().map(|log| record(log, residual(log, c), ts)).collect();
            fit_linear(&records?, kind)
        };
        each(0..ny, of_output).into_iter().collect::<Option<Vec<ArxModel>>>()
    };
    let loss = |models: &[ArxModel], residual: &dyn Fn(&Trained, usize) -> Vec<f64>| {
        let mut sums = [0.0; 2];
        for log in training {
            for (c, model) in models.iter().enumerate() {
                let bias = simulate_linear(model, log, c, ts)?;
                let [sum, n] = mean_square(&residual(log, c), &bias);
                sums = [sums[0] + sum, sums[1] + n];
            }
        }
        Some(sums[0] / sums[1])
    };
    let plain = LINEAR.map(|orders| Kind { orders, is_refined: false });
    let refined = REFINED.map(|orders| Kind { orders, is_refined: true });
    let scored = plain.into_iter().chain(refined).filter_map(|kind| {
        let models = fit(kind, &|log, c| part(&log.residual[c], true))?;
        Some((loss(&models, &|log, c| part(&log.residual[c], false))?, kind, models))
    });
    let (_, kind, models) = scored.min_by(|a, b| a.0.total_cmp(&b.0))?;
    // A fit to all of the training need not be better in free run than that to a part of it.
    let all = |log: &Trained, c: usize| log.residual[c].clone();
    let whole = fit(kind, &all).and_then(|whole| Some((loss(&whole, &all)?, whole)));
    let known = loss(&models, &all)?;
    let models = whole.filter(|(loss, _)| *loss < known).map_or(models, |(_, whole)| whole);
    Some((kind.orders, models))
}

/// A nonlinear equation per output, with the feedback and ridge that forecast the last third of the
/// training best.
fn nonlinear(training: &[Trained], ny: usize, seed: u64) -> Option<(usize, Vec<Network>)> {
    let drivers: Vec<Vec<Vec<f64>>> = training.iter().map(drivers).collect();
    let regression = |na: usize, c: usize, residual: &dyn Fn(&[f64]) -> Vec<f64>| {
        let pairs = training.iter().zip(&drivers);
        let examples: Vec<Example<'_>> = pairs
            .map(|(log, drivers)| Example { drivers, residual: residual(&log.residual[c]) })
            .collect();
        Regression::new(&examples, na, seed)
    };
    let errors = |network: &Network, c: usize| {
        let of_log = |(log, drivers): (&Trained, &Vec<Vec<f64>>)| {
            mean_square(&part(&log.residual[c], false), &network.run(drivers))
        };
        let all = training.iter().zip(&drivers).map(of_log);
        all.fold([0.0; 2], |[sum, n], [more, samples]| [sum + more, n + samples])
    };
    // Per output and ridge, for one feedback.
    let losses = |na: usize| -> Vec<(f64, (usize, f64))> {
        let of_output = |c: usize| -> Option<Vec<Option<[f64; 2]>>> {
            let regression = regression(na, c, &|residual| part(residual, true))?;
            Some(RIDGES.map(|ridge| Some(errors(&regression.with_ridge(ridge)?, c))).to_vec())
        };
        let outputs = each(0..ny, of_output);
        let of_ridge = |(i, ridge): (usize, &f64)| {
            let mut total = [0.0; 2];
            for output in &outputs {
                let [sum, n] = output.as_ref()?[i]?;
                total = [total[0] + sum, total[1] + n];
            }
            Some((total[0] / total[1], (na, *ridge))).filter(|(loss, _)| loss.is_finite())
        };
        RIDGES.iter().enumerate().filter_map(of_ridge).collect()
    };
    let (_, (na, ridge)) =
        FEEDBACKS.into_iter().flat_map(losses).min_by(|a, b| a.0.total_cmp(&b.0))?;
    let whole = |c: usize| regression(na, c, &<[f64]>::to_vec)?.with_ridge(ridge);
    let networks: Option<Vec<Network>> = each(0..ny, whole).into_iter().collect();
    Some((na, networks?))
}

fn words(ceiling: &Ceiling) -> String {
    let share = |kind: &str, compensation: &Option<Compensation>| {
        let closed = compensation.as_ref()?.closed?;
        // Zero has no sign.
        let [share, low, high] = [closed.fraction, closed.interval[0], closed.interval[1]]
            .map(|v| (100.0 * v).round() + 0.0);
        let is_nothing = share <= 0.0;
        Some(if is_nothing {
            format!("{kind} nothing ({low}..{high} %)")
        } else {
            format!("{kind} {share} % ({low}..{high})")
        })
    };
    let shares: Vec<String> =
        [share("a linear one", &ceiling.linear), share("a nonlinear one", &ceiling.nonlinear)]
            .into_iter()
            .flatten()
            .collect();
    if shares.is_empty() {
        return "there is no held-out gap that a black box could remove".to_owned();
    }
    format!(
        "of the held-out gap above the noise, a black-box compensation removes: {}",
        shares.join(", ")
    )
}
