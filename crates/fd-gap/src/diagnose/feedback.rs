//! Did the controller of the real loop see what was logged?

use std::sync::Arc;

use fd_model::Record;
use fd_sim::{
    model::Model,
    simulate::{LoggedLoop, Nominal, Outcome},
};

use super::{
    case::Case,
    commanded::commanded,
    prepare::{Prepared, prepare},
    settings::{ControllerSees, Settings},
};
use crate::{
    evidence::{NoisePrior, likelihood},
    fit::{FitError, Horizon, Log, Plan, Problem},
};

/// Noise of any size and colour.
const ANY: NoisePrior = NoisePrior { centre: 0.0, spread: 1e3, is_coloured: true, step: None };

/// Change of an initial state, in its size or its unit, of which the growth is looked at …
const NUDGE: f64 = 1e-6;
/// … and growth from the first to the last quarter of a log of what runs away: two integrators in a row grow by 16.
const RUNS_AWAY: f64 = 100.0;

/// The loop as it is diagnosed: closed, or with the controller on logged outputs.
#[derive(Debug)]
pub(super) struct Feedback<'a> {
    logged: Option<Logged<'a>>,
    /// Whether the controller can act on logged outputs.
    can_see_the_log: bool,
}

/// A controller on logged outputs, with the records that have these as inputs.
#[derive(Debug)]
struct Logged<'a> {
    nominal: LoggedLoop<'a>,
    logs: Vec<Record>,
    held_out: Vec<Record>,
    /// The same as they came, without what the controller makes of them, if it makes anything.
    plain: Option<[Vec<Record>; 2]>,
}

impl<'a> Feedback<'a> {
    /// Chooses by what the fit of the nuisances leaves. An effect leaves much either way; what tells
    /// the two apart is the noise, so that the innovations of what is left are compared.
    pub(super) fn of(case: &Case<'a>, settings: &Settings) -> Self {
        let logged = Logged::of(case);
        let can_see_the_log = logged.is_some();
        let logged = logged.filter(|logged| match settings.controller_sees {
            ControllerSees::Simulated => false,
            ControllerSees::Logged => true,
            ControllerSees::Either => saw_the_log(&logged.case(case), case, settings.horizon),
        });
        Self { logged, can_see_the_log }
    }

    /// What is diagnosed.
    pub(super) fn case<'b>(&'b self, case: &Case<'b>) -> Case<'b> {
        self.logged.as_ref().map_or(*case, |logged| logged.case(case))
    }

    /// The case as it came, without what the controller makes of the log.
    pub(super) fn plain<'b>(&'b self, case: &Case<'b>) -> Case<'b> {
        let plain = self.logged.as_ref().and_then(|logged| logged.plain.as_ref());
        plain.map_or(*case, |[logs, held_out]| Case { logs, held_out, ..*case })
    }

    /// Whether the controller acts on logged outputs.
    pub(super) fn is_logged(&self) -> bool {
        self.logged.is_some()
    }

    /// Whether it can.
    pub(super) fn can_see_the_log(&self) -> bool {
        self.can_see_the_log
    }

    /// A problem with the loop closed, of which `model` is the (patched) model; the same unknowns
    /// mean the same.
    pub(super) fn closed(
        &self,
        case: &Case<'_>,
        model: &Model,
        problem: &Problem,
    ) -> Result<Problem, FitError> {
        if !self.is_logged() {
            return Ok(problem.clone());
        }
        let simulator = case.nominal.patched(model, problem.simulator().ts())?;
        let logs = Log::held_out(case.logs, &*simulator, &[], &problem.plan().logs)?;
        let plan = Plan { logs, ..(**problem.plan()).clone() };
        let (effects, weights) = (problem.effects().to_vec(), problem.weights().clone());
        Problem::new(Arc::new(plan), simulator, effects, weights)
    }
}

impl<'a> Logged<'a> {
    fn of(case: &Case<'a>) -> Option<Self> {
        let nominal = LoggedLoop::of(case.nominal, case.logs.first()?.ts())?;
        let commanded = commanded(&nominal, case.logs);
        let nominal = nominal.with_commanded(&commanded);
        let all = |records: &[Record]| -> Option<Vec<Record>> {
            records.iter().map(|record| nominal.record(record).ok()).collect()
        };
        let (logs, held_out) = (all(case.logs)?, all(case.held_out)?);
        if runs_away(&nominal, logs.first()?) {
            return None;
        }
        let plain = |records: &[Record]| -> Option<Vec<Record>> {
            records.iter().map(|record| nominal.without_commanded(record).ok()).collect()
        };
        let plain = if commanded.is_empty() {
            None
        } else {
            Some([plain(case.logs)?, plain(case.held_out)?])
        };
        Some(Self { nominal, logs, held_out, plain })
    }

    fn case<'b>(&'b self, case: &Case<'b>) -> Case<'b> {
        let Self { nominal, logs, held_out, .. } = self;
        Case { nominal, suspects: case.suspects, logs, held_out }
    }
}

/// Whether a plant on logged outputs, which nobody holds, leaves wherever it begins: a tiny change of some initial state
/// grows beyond all bounds.
fn runs_away(nominal: &dyn Nominal, record: &Record) -> bool {
    let Ok(mut simulator) = nominal.simulator(record.ts()) else { return true };
    let theta: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
    let x0: Vec<f64> = simulator.initial().iter().map(|state| state.value).collect();
    let u: Vec<f64> = (0..record.len()).flat_map(|k| record.u(k).to_vec()).collect();
    let ny = simulator.outputs().len();
    let mut run = |x0: &[f64]| {
        let mut y = vec![0.0; record.len() * ny];
        (simulator.simulate(&theta, x0, &u, &mut y) == Outcome::Complete).then_some(y)
    };
    let Some(plain) = run(&x0) else { return true };
    (0..x0.len()).any(|i| {
        let mut moved = x0.clone();
        moved[i] += NUDGE * x0[i].abs().max(1.0);
        let Some(there) = run(&moved) else { return true };
        let quarter = record.len() / 4 * ny;
        let largest = |c: usize, part: std::ops::Range<usize>| {
            let pairs = there[part.clone()].iter().zip(&plain[part]).skip(c).step_by(ny);
            pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        (0..ny).any(|c| RUNS_AWAY * largest(c, 0..quarter) < largest(c, 3 * quarter..there.len()))
    })
}

/// Whether a controller saw what was logged: the logs of a case that is `open`, with a controller on logged outputs, or only
/// held along the log, against the same case in a `closed` loop, whose controller sees what is simulated. Commands that follow from
/// what was logged show it; else it is decided by what the model leaves of the logs without any effect, as noise of any size and
/// colour.
///
/// ```
/// use fd_effect::Candidate;
/// use fd_gap::{diagnose::{Case, saw_the_log}, fit::Horizon};
/// use fd_model::{Channel, Record};
/// use fd_sim::model::Model;
///
/// let lag = |time: &str| format!(r#"
/// version = 1
/// kind = "equations"
/// name = "lag"
/// sample_time = 0.1
/// inputs = {{ u = {{ unit = "V" }} }}
/// outputs = {{ y = {{ unit = "V", value = "x" }} }}
/// states = {{ x = {{ unit = "V", initial = 0.0, derivative = "(u - x)/{time}" }} }}
/// "#).parse::<Model>();
/// let (u, y) = ([Channel::new("u", "V")], [Channel::new("y", "V")]);
/// let row = |k: u32| {
///     let noise = 0.01 * f64::from(k * 7919 % 13).sin();
///     ([1.0], [1.0 - (-0.1 * f64::from(k)).exp() + noise])
/// };
/// let (right, wrong) = (lag("1")?, lag("2")?);
/// let log = Record::from_rows(u.to_vec(), y.to_vec(), (0..100).map(row), right.sample_time()?)?;
/// let none: Vec<Candidate> = Vec::new();
/// let logs = [log];
/// let [right, wrong] =
///     [&right, &wrong].map(|nominal| Case { nominal, suspects: &none, logs: &logs, held_out: &[] });
/// assert!(saw_the_log(&right, &wrong, Horizon::FreeRun));
/// assert!(!saw_the_log(&wrong, &right, Horizon::FreeRun));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn saw_the_log(open: &Case<'_>, closed: &Case<'_>, horizon: Horizon) -> bool {
    if !open.nominal.commanded().is_empty() {
        return true;
    }
    let likelihood = |case| prepare(case, horizon).ok().as_ref().and_then(log_likelihood);
    likelihood(open).is_some_and(|open| likelihood(closed).is_none_or(|closed| closed < open))
}

/// Of what a fit leaves, in physical units, as noise of any size and colour.
fn log_likelihood(Prepared { null, .. }: &Prepared) -> Option<f64> {
    let mut problem = null.problem.clone();
    let errors = problem.errors(&null.minimum.z)?;
    let found = likelihood(&errors, &vec![ANY; errors.len()]);
    let scale = |(signals, sigma): (&Vec<Vec<f64>>, &f64)| {
        signals.iter().flatten().filter(|e| e.is_finite()).count() as f64 * sigma.ln()
    };
    let scales: f64 = errors.iter().zip(&problem.weights().sigma).map(scale).sum();
    let log = found.log - scales;
    log.is_finite().then_some(log)
}
