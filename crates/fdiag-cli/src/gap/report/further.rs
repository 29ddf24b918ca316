//! What goes beyond the log: a black box, another experiment, simulated logs of known cause.

use fd_gap::{
    calibrate::Confusion,
    ceiling::{Ceiling, Compensation},
    diagnose::CauseId,
    experiment::{Advice, Rival},
};
use serde::Serialize;

use super::{CauseReport, ClosedReport, PairReport};
use crate::gap::headline::capital;

/// What a black-box compensation could remove, whatever the cause.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CeilingReport {
    /// The linear bias model of Patton & Chen (1992), in free run.
    pub linear: Option<CompensationReport>,
    /// A small nonlinear one.
    pub nonlinear: Option<CompensationReport>,
    /// In words.
    pub statement: String,
}

/// A black-box compensation.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CompensationReport {
    /// Past values of the bias, and of each input, that it uses.
    pub orders: [usize; 2],
    /// Held-out gap of each output with it, in its unit, in the order of `noise`.
    pub after: Vec<f64>,
    /// Share of the gap of the refitted model that it closes.
    pub closed: Option<ClosedReport>,
}

/// What would separate causes that this log cannot tell apart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AdviceReport {
    /// Places in `causes` of those to be told apart, the first one first; neither pairs nor "no gap".
    pub between: Vec<usize>,
    /// Everything that is to be told apart, in words, the first one first.
    pub rivals: Vec<String>,
    /// Squares of the noise by which the present logs separate them.
    pub now: f64,
    /// Experiments that were simulated.
    pub tried: Vec<TriedExperiment>,
    /// Place in `tried` of the advised one.
    pub best: Option<usize>,
    /// In words.
    pub statement: String,
}

/// An experiment that was simulated.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TriedExperiment {
    /// In words.
    pub name: String,
    /// An additional sensor: the state that it measures.
    pub sensor: Option<String>,
    /// How many times faster outputs are sampled.
    pub faster: u32,
    /// Squares of the noise by which it would separate each of the causes from the first.
    pub distances: Vec<f64>,
}

/// What the same diagnosis says of simulated logs of known cause.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CalibrationReport {
    /// True causes, one row each.
    pub truths: Vec<String>,
    /// Answers, one column each.
    pub answers: Vec<String>,
    /// Replicas with a true cause (row) and an answer (column).
    pub counts: Vec<Vec<usize>>,
    /// Replicas per row.
    pub replicas: Vec<usize>,
    /// Share of right answers, tied ones included.
    pub accuracy: f64,
    /// Mean of the highest probabilities that were given.
    pub confidence: f64,
    /// Temperature with which probabilities would be the most honest.
    pub temperature: f64,
    /// Answers with at least this probability contain the truth in 90 % of such logs.
    pub threshold: f64,
    /// Mean number of answers in that set.
    pub set_size: f64,
    /// That set for these logs, in words.
    pub set: Vec<String>,
    /// In words.
    pub statement: String,
}

impl CeilingReport {
    pub(in crate::gap) fn of(ceiling: &Ceiling) -> Self {
        let compensation = |c: &Compensation| CompensationReport {
            orders: c.orders,
            after: c.after.clone(),
            closed: c.closed.as_ref().map(ClosedReport::from),
        };
        Self {
            linear: ceiling.linear.as_ref().map(compensation),
            nonlinear: ceiling.nonlinear.as_ref().map(compensation),
            statement: ceiling.statement.clone(),
        }
    }
}

impl AdviceReport {
    pub(in crate::gap) fn of(
        advice: &Advice,
        causes: &[CauseReport],
        pairs: &[PairReport],
    ) -> Self {
        let place = |rival: &Rival| match rival {
            Rival::Cause(id) => Some(id.0),
            Rival::NoGap | Rival::Pair(_) => None,
        };
        let cause = |id: &CauseId| causes.get(id.0).map(|cause| cause.name.clone());
        let name = |rival: &Rival| match rival {
            Rival::NoGap => Some("no gap".to_owned()),
            Rival::Cause(id) => cause(id),
            Rival::Pair(id) => pairs.get(id.0).map(PairReport::name),
        };
        let rivals: Vec<String> = advice.between.iter().filter_map(name).collect();
        // The same names as everywhere in the report.
        let pairs = advice.names.iter().zip(&rivals);
        let statement = pairs.fold(advice.statement.clone(), |s, (from, to)| s.replace(from, to));
        let tried = advice.tried.iter().map(|separation| TriedExperiment {
            name: separation.experiment.name.clone(),
            sensor: separation.experiment.sensor.as_ref().map(|(state, _)| state.clone()),
            faster: separation.experiment.faster,
            distances: separation.distances.clone(),
        });
        Self {
            between: advice.between.iter().filter_map(place).collect(),
            now: advice.now,
            tried: tried.collect(),
            best: advice.best,
            statement: capital(&statement),
            rivals,
        }
    }
}

impl CalibrationReport {
    pub(in crate::gap) fn of(confusion: &Confusion, causes: &[CauseReport]) -> Self {
        let name = |cause: Option<CauseId>, otherwise: &str| match cause {
            None => "no gap".to_owned(),
            Some(id) => causes.get(id.0).map_or(otherwise.to_owned(), |c| c.name.clone()),
        };
        let truths: Vec<String> =
            confusion.truths.iter().map(|truth| name(truth.cause, &truth.name)).collect();
        let answers = (0..confusion.columns.len())
            .map(|i| truths.get(i).unwrap_or(&confusion.columns[i]).clone());
        Self {
            answers: answers.collect(),
            counts: confusion.counts.clone(),
            replicas: confusion.replicas.clone(),
            accuracy: confusion.accuracy,
            confidence: confusion.confidence,
            temperature: confusion.temperature,
            threshold: confusion.threshold,
            set_size: confusion.set_size,
            set: confusion.set.iter().map(|cause| name(*cause, "another cause")).collect(),
            statement: confusion.statement.clone(),
            truths,
        }
    }
}
