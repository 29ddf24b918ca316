//! The experiment, sensor or sampling that would separate causes that a log cannot.
//!
//! An experiment separates two causes when one of them, refitted to what the other predicts of the present logs
//! *and* of the new one together, leaves many squares of the noise (more than 9): the new data must not be
//! explained by another strength or other parameters. The following are tried: inputs within the range of the
//! logs, the logged input at twice its amplitude, then sensors of states that are not logged, then four times
//! the sample rate. The first kind that separates all causes is recommended.
//!
//! *When not to use:* predictions are those of the fitted causes; when none of them is right, the advice is
//! irrelevant. Inputs for which the leading cause is chaotic or diverges are excluded.

mod arena;
mod excitation;
mod result;
mod rival;

use crate::together::each;
use fd_numeric::upper_median;

pub use self::result::{Advice, Excitation, Experiment, Reach, Rival, Sensor, Separation};
use self::{
    arena::Arena,
    excitation::{ALL, inputs},
    rival::{between, contenders, leader},
};
use crate::{
    diagnose::{Case, Diagnosis, Monitor, Stage},
    evidence::SEPARATED,
    fit::{FitError, Log},
    locate::bench::{Bench, settled},
};

/// Most sensors that are tried.
const MOST_SENSORS: usize = 4;
/// Longest experiment that is simulated by default, in samples.
const LONGEST: usize = 1000;
/// How many times faster sampling could be.
const FASTER: u32 = 4;

/// The experiment of least effort that would separate the leading cause, or pair of causes, from those
/// that are tied with it, or else from its rivals; "no gap" is one as long as it is not out of the
/// question. The monitor sees [`Stage::Experiment`], once per kind of experiment.
///
/// ```
/// use fd_effect::Candidate;
/// use fd_gap::{diagnose::{Case, Settings, diagnose}, experiment::{Reach, next}};
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
/// let advice = next(&case, &diagnosis, &Reach::default(), &())?;
/// assert_eq!(advice.statement, "there is nothing to separate");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Returns an error when the model cannot be simulated or does not fit the logs of the case.
pub fn next(
    case: &Case<'_>,
    diagnosis: &Diagnosis,
    reach: &Reach,
    monitor: &dyn Monitor,
) -> Result<Advice, FitError> {
    let between = between(diagnosis);
    let nothing = |statement: &str| Advice {
        between: Vec::new(),
        names: Vec::new(),
        now: f64::INFINITY,
        tried: Vec::new(),
        best: None,
        statement: statement.to_owned(),
    };
    let [first, others @ ..] = between.as_slice() else {
        return Ok(nothing("there is nothing to separate"));
    };
    let Some((model, starts)) = leader(diagnosis, *first) else {
        return Ok(nothing("there is nothing to separate"));
    };
    let bench = Bench::new(case, diagnosis)?;
    let rivals = contenders(case, diagnosis, others);
    let arena = |sensor: Option<Sensor>, faster: u32| {
        Arena::new(case, &bench, model, starts, sensor, faster)
    };
    let present = arena(None, 1).and_then(|mut arena| arena.distances(&rivals, None));
    let Some(now) = present.filter(|_| rivals.len() == others.len()) else {
        return Ok(nothing("the causes that are left cannot be simulated again"));
    };
    let now = now.into_iter().fold(f64::INFINITY, f64::min);
    let try_all = |experiments: Vec<Experiment>| -> Vec<Separation> {
        monitor.begin(Stage::Experiment, experiments.len());
        let tried = each(experiments, |experiment| {
            let distances = arena(experiment.sensor.clone(), experiment.faster)
                .and_then(|mut arena| arena.distances(&rivals, Some(&experiment.u)));
            monitor.advance();
            Some(Separation { experiment, distances: distances? })
        });
        let mut tried: Vec<Separation> = tried.into_iter().flatten().collect();
        tried.sort_by(|a, b| b.least().total_cmp(&a.least()));
        tried
    };
    let is_enough = |tried: &[Separation]| tried.iter().any(|t| SEPARATED <= t.least());
    let mut tried = try_all(other_inputs(&bench, reach));
    // The most separating input, and the one that needs no change, with more to see.
    let mut base: Vec<(Excitation, Vec<f64>)> = Vec::new();
    let logged = tried.iter().find(|t| t.experiment.excitation == Excitation::Logged);
    for separation in tried.first().into_iter().chain(logged) {
        let Experiment { excitation, u, .. } = &separation.experiment;
        if base.iter().all(|(known, _)| known != excitation) {
            base.push((*excitation, u.clone()));
        }
    }
    if reach.can_measure && !is_enough(&tried) {
        let sensors = sensors(case, diagnosis, &bench)?;
        let experiment = |sensor: Sensor| {
            base.iter().take(1).map(move |(excitation, u)| Experiment {
                excitation: *excitation,
                u: u.clone(),
                name: format!("{}, with `{}` measured as well", excitation.name(), sensor.state),
                sensor: Some(sensor.clone()),
                faster: 1,
            })
        };
        tried.extend(try_all(sensors.into_iter().flat_map(experiment).collect()));
    }
    if reach.can_sample_faster && !is_enough(&tried) {
        let experiment = |(excitation, u): &(Excitation, Vec<f64>)| Experiment {
            excitation: *excitation,
            u: u.clone(),
            name: format!("{}, sampled four times faster", excitation.name()),
            sensor: None,
            faster: FASTER,
        };
        tried.extend(try_all(base.iter().map(experiment).collect()));
    }
    let best = tried.iter().position(|t| SEPARATED <= t.least());
    let names: Vec<String> = between.iter().map(|r| rival::words(diagnosis, *r)).collect();
    let statement = words(&names, now, &tried, best, reach);
    Ok(Advice { between, names, now, tried, best, statement })
}

fn other_inputs(bench: &Bench, reach: &Reach) -> Vec<Experiment> {
    let longest = bench.logs.iter().max_by_key(|log| log.samples);
    let Some(log) = longest else { return Vec::new() };
    let samples = reach.samples.unwrap_or(log.samples.min(LONGEST)).max(2);
    let ranges: Vec<[f64; 2]> = (0..log.nu).map(|i| range(&bench.logs, i)).collect();
    let experiment = |excitation: Excitation| {
        // A log too short for a kind of signal goes without it.
        let u = inputs(excitation, log, &ranges, samples, bench.simulator.ts(), reach).ok()?;
        let name = excitation.name().to_owned();
        Some(Experiment { excitation, u, sensor: None, faster: 1, name })
    };
    ALL.into_iter().filter_map(experiment).collect()
}

fn range(logs: &[Log], input: usize) -> [f64; 2] {
    let values = logs.iter().flat_map(|log| log.u.iter().skip(input).step_by(log.nu));
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(*v), high.max(*v)])
}

/// States that no output shows as they are, with a noise that is as large against their motion as
/// that of the outputs is in the median.
fn sensors(case: &Case<'_>, diagnosis: &Diagnosis, bench: &Bench) -> Result<Vec<Sensor>, FitError> {
    let refit = &diagnosis.refit;
    let mut simulator = case.nominal.patched(&refit.model, bench.simulator.ts())?;
    let theta = settled(&*simulator);
    let run = bench.run(&mut *simulator, &theta, &refit.starts, &Vec::new());
    let (outputs, states) = run.ok_or(FitError::Diverged)?;
    let spread = |rows: &[Vec<f64>], i: usize, width: usize| {
        let values = rows.iter().flat_map(|r| r.iter().skip(i).step_by(width)).copied();
        fd_numeric::mean_and_deviation(values)[1]
    };
    let ny = bench.ny();
    let mut ratios: Vec<f64> = (bench.sigma.iter().enumerate())
        .map(|(c, sigma)| sigma / spread(&outputs, c, ny))
        .filter(|ratio| ratio.is_finite())
        .collect();
    let ratio = upper_median(&mut ratios).unwrap_or(0.01);
    let model = case.nominal.model();
    let is_logged = |name: &str| {
        model.outputs.iter().any(|output| output.value == fd_sim::equation::Expr::name(name))
    };
    let initial = simulator.initial();
    let sensor = |(i, state): (usize, &fd_sim::simulate::Initial)| {
        let noise = ratio * spread(&states, i, initial.len());
        let name = &state.channel.name;
        (!is_logged(name) && 0.0 < noise).then(|| Sensor { state: name.clone(), noise })
    };
    Ok(initial.iter().enumerate().filter_map(sensor).take(MOST_SENSORS).collect())
}

fn words(
    names: &[String],
    now: f64,
    tried: &[Separation],
    best: Option<usize>,
    reach: &Reach,
) -> String {
    let pair = match names {
        [first, second] => format!("{first} and {second}"),
        names => names.join(", "),
    };
    let Some(best) = best.map(|best| &tried[best]) else {
        let most = tried.iter().map(Separation::least).fold(now, f64::max);
        let mut also = String::new();
        if reach.can_measure && tried.iter().any(|t| t.experiment.sensor.is_some()) {
            also += ", nor does a sensor of another state";
        }
        if reach.can_sample_faster && tried.iter().any(|t| 1 < t.experiment.faster) {
            also += ", nor does sampling four times faster";
        }
        let distance = if most < now + 0.05 {
            format!("stays at {now:.1}")
        } else {
            format!("rises from {now:.1} to at most {most:.1}")
        };
        return format!(
            "no input within reach separates {pair}{also}: the distance {distance} squares of the \
             noise, where 9 are needed"
        );
    };
    let rises = format!("from {now:.1} to {:.0} squares of the noise", best.least());
    match &best.experiment {
        Experiment { sensor: Some(Sensor { state, .. }), .. } => format!(
            "no input within reach separates {pair}: measure `{state}` as well, and the distance \
             rises {rises}"
        ),
        Experiment { faster: 2.., .. } => format!(
            "no input within reach separates {pair}: sample four times faster, and the distance \
             rises {rises}"
        ),
        experiment => {
            format!("run {}: the distance between {pair} rises {rises}", experiment.name)
        }
    }
}
