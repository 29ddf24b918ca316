//! Did the controller of the real loop see what was logged?

use std::sync::Arc;

use fd_model::Record;
use fd_sim::{model::Model, simulate::LoggedLoop};

use super::{
    case::Case,
    prepare::{Prepared, prepare},
    settings::Settings,
};
use crate::{
    evidence::{NoisePrior, likelihood},
    fit::{FitError, Log, Plan, Problem},
};

/// Noise of any size and colour.
const ANY: NoisePrior = NoisePrior { centre: 0.0, spread: 1e3, is_coloured: true, step: None };

/// The loop as it is diagnosed: closed, or with the controller on logged outputs.
#[derive(Debug)]
pub(super) struct Feedback<'a> {
    logged: Option<Logged<'a>>,
}

/// A controller on logged outputs, with the records that have these as inputs.
#[derive(Debug)]
struct Logged<'a> {
    nominal: LoggedLoop<'a>,
    logs: Vec<Record>,
    held_out: Vec<Record>,
}

impl<'a> Feedback<'a> {
    /// Chooses by what the fit of the nuisances leaves. An effect leaves much either way; what tells
    /// the two apart is the noise, so that the innovations of what is left are compared.
    pub(super) fn of(case: &Case<'a>, settings: &Settings) -> Self {
        let horizon = settings.horizon;
        let logged = if settings.without.logged_loops { None } else { Logged::of(case) };
        let logged = logged.filter(|logged| {
            let open = prepare(&logged.case(case), horizon).ok().and_then(|p| log_likelihood(&p));
            let closed = prepare(case, horizon).ok().and_then(|p| log_likelihood(&p));
            open.is_some_and(|open| closed.is_none_or(|closed| closed < open))
        });
        Self { logged }
    }

    /// What is diagnosed.
    pub(super) fn case<'b>(&'b self, case: &Case<'b>) -> Case<'b> {
        self.logged.as_ref().map_or(*case, |logged| logged.case(case))
    }

    /// Whether the controller acts on logged outputs.
    pub(super) fn is_logged(&self) -> bool {
        self.logged.is_some()
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
        let logs = Log::held_out(case.logs, &*simulator, &[], problem.plan())?;
        let plan = Plan { logs, ..(**problem.plan()).clone() };
        let (effects, weights) = (problem.effects().to_vec(), problem.weights().clone());
        Problem::new(Arc::new(plan), simulator, effects, weights)
    }
}

impl<'a> Logged<'a> {
    fn of(case: &Case<'a>) -> Option<Self> {
        let nominal = LoggedLoop::of(case.nominal, case.logs.first()?.ts())?;
        let all = |records: &[Record]| -> Option<Vec<Record>> {
            records.iter().map(|record| nominal.record(record).ok()).collect()
        };
        let (logs, held_out) = (all(case.logs)?, all(case.held_out)?);
        Some(Self { nominal, logs, held_out })
    }

    fn case<'b>(&'b self, case: &Case<'b>) -> Case<'b> {
        let Self { nominal, logs, held_out } = self;
        Case { nominal, suspects: case.suspects, logs, held_out }
    }
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
