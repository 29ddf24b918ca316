//! Diagnosis with few runs of simulators that are expensive to run.

use fd_gap::{
    diagnose::{Case, Cause, Diagnosis, Monitor, Settings, diagnose},
    few_runs::{Effort, FewRuns, with_few_runs},
};
use fd_model::{Record, figure};
use fd_sim::{
    outside::OutsideSimulator,
    scales::ReplayScales,
    simulate::{Shell, Simulator},
};
use schemars::JsonSchema;
use serde::Serialize;

use super::{error::GapError, request::Request, subject::Subject};

/// Runs that a diagnosis makes besides those of the stand-in, of causes and of pairs: the fit of the parameters,
/// forecasts, places.
const ALWAYS: u64 = 40;
/// Runs that it takes to confirm a cause, and a pair.
const PER_CAUSE: u64 = 10;
const PER_PAIR: u64 = 35;
/// Fewest causes that are worth a confirmation.
const FEWEST_CAUSES: u64 = 2;
/// Runs of a search on the simulator itself.
const THOROUGH: u64 = 8000;
/// Most seconds that runs of limits may take, as many as a search makes, for them to be tried without being asked.
const PATIENCE: f64 = 600.0;
/// A plan that takes longer, in seconds, is said before it begins.
const LONG: f64 = 2.0;

/// How a simulator outside of this program was diagnosed with few runs.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Sparing {
    /// Share of a disturbance of all inputs, forces and parameters that the linearised simulator foretells, 0 to 1.
    pub foretold: f64,
    /// Runs through the logs that it was linearised with.
    pub linearised_with: usize,
    /// Causes that were tried on the linearised simulator.
    pub proposed: usize,
    /// Causes that were tried on the simulator itself.
    pub confirmed: usize,
    /// Causes and pairs that the linearised simulator would rather have than no gap, and that were not tried on the
    /// simulator itself; the best first.
    pub left_out: Vec<String>,
    /// Whether limits, of which the linearised simulator knows nothing, were tried on the simulator itself: where
    /// nothing that was proposed is the cause, unless that would take long.
    pub limits: bool,
    /// What was allowed; `null` where nothing was said.
    pub budget: Option<String>,
}

/// A diagnosis, and how few runs it was made with.
pub(super) struct Spared {
    pub diagnosis: Diagnosis,
    /// How that was done, and the simulator for further questions to the same logs.
    pub sparing: Option<(Sparing, Shell)>,
}

/// Diagnoses a case; one of a simulator outside of this program with few runs, unless the request or the simulator
/// is against it.
pub(super) fn diagnose_sparing(
    request: &Request,
    subject: &Subject,
    scales: &ReplayScales,
    case: &Case<'_>,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Spared, GapError> {
    if let Some((simulator, shell)) = subject.black_box()
        && !request.thorough
    {
        let work = Work::of(simulator, case);
        let effort = work.effort(request)?;
        work.tell(effort, monitor);
        let forces: Vec<f64> = scales.sites.iter().map(|site| site.force).collect();
        if let Some(few) = with_few_runs(shell, &forces, case, settings, effort, monitor)? {
            let (sparing, FewRuns { diagnosis, lent, .. }) =
                (Sparing::of(&few, effort, request), few);
            return Ok(Spared { diagnosis, sparing: Some((sparing, lent)) });
        }
        work.check_thorough(request)?;
        monitor.plan(
            "The simulator cannot be linearised along these logs well enough to propose causes: everything is tried \
             on the simulator itself.",
        );
    }
    Ok(Spared { diagnosis: diagnose(case, settings, monitor)?, sparing: None })
}

/// Runs that it takes to linearise a simulator.
fn stand_in(simulator: &OutsideSimulator) -> u64 {
    let moved = simulator.initial().len()
        + simulator.inputs().len()
        + simulator.ports().len()
        + simulator.parameters().len();
    2 + moved as u64
}

/// Runs that it takes to confirm what the linearised simulator proposes.
fn confirm(effort: Effort) -> u64 {
    ALWAYS + effort.causes as u64 * PER_CAUSE + effort.pairs as u64 * PER_PAIR
}

/// Most runs of a simulator that a diagnosis is planned with.
pub(super) fn planned_runs(simulator: &OutsideSimulator) -> u64 {
    stand_in(simulator) + confirm(Effort::default())
}

/// What runs of a simulator cost.
struct Work {
    /// Seconds of a run through all logs, with all workers at work; 0 where it is not known yet.
    seconds: f64,
    /// Runs that it takes to linearise it.
    stand_in: u64,
}

impl Work {
    fn of(simulator: &OutsideSimulator, case: &Case<'_>) -> Self {
        let counts = simulator.counts();
        let per_step = counts.inside.as_secs_f64() / (counts.steps.max(1) as f64);
        let samples: usize = case.logs.iter().map(Record::len).sum();
        let per_sample =
            case.logs.first().map_or(1.0, |log| log.ts().seconds() / simulator.ts().seconds());
        let workers = simulator.workers() as f64;
        Self {
            seconds: per_step * samples as f64 * per_sample / workers,
            stand_in: stand_in(simulator),
        }
    }

    /// What can be confirmed with the budget of a request.
    fn effort(&self, request: &Request) -> Result<Effort, GapError> {
        let plenty = Effort::default();
        let Some(budget) = request.budget else {
            return Ok(Effort { limits: self.seconds * THOROUGH as f64 <= PATIENCE, ..plenty });
        };
        let runs = budget.runs(self.seconds);
        let needed = self.stand_in + ALWAYS + FEWEST_CAUSES * PER_CAUSE;
        if runs < needed {
            return Err(self.too_little(request, needed));
        }
        let left = runs - self.stand_in - ALWAYS;
        let causes = (left / PER_CAUSE).min(plenty.causes as u64);
        let pairs = ((left - causes * PER_CAUSE) / PER_PAIR).min(plenty.pairs as u64);
        Ok(Effort {
            causes: to_usize(causes),
            pairs: to_usize(pairs),
            limits: needed + THOROUGH <= runs,
        })
    }

    /// Where there is no way but a search on the simulator itself, the budget must allow that.
    fn check_thorough(&self, request: &Request) -> Result<(), GapError> {
        let is_enough = |budget: &super::Budget| THOROUGH <= budget.runs(self.seconds);
        match &request.budget {
            Some(budget) if !is_enough(budget) => Err(self.too_little(request, THOROUGH)),
            _ => Ok(()),
        }
    }

    fn too_little(&self, request: &Request, needed: u64) -> GapError {
        let found = request.budget.map_or_else(String::new, |budget| budget.to_string());
        let seconds = figure(self.seconds * needed as f64);
        GapError::Budget { needed, seconds, found }
    }

    fn tell(&self, effort: Effort, monitor: &dyn Monitor) {
        let Effort { causes, pairs, .. } = effort;
        let confirm = confirm(effort);
        let seconds = self.seconds * (self.stand_in + confirm) as f64;
        if seconds < LONG {
            return;
        }
        monitor.plan(&format!(
            "A run of the simulator through the logs takes {} s. The plan is {} runs to linearise it and up to \
             {confirm} to confirm {causes} causes and {pairs} pairs: {} s.",
            figure(self.seconds),
            self.stand_in,
            figure(seconds),
        ));
    }
}

fn to_usize(n: u64) -> usize {
    usize::try_from(n).unwrap_or(usize::MAX)
}

impl Sparing {
    fn of(few: &FewRuns, effort: Effort, request: &Request) -> Self {
        let FewRuns { proposed, explains, runs, .. } = few;
        let name = |cause: &Cause| match cause.site.name() {
            Some(site) => format!("{}@{site}", cause.label),
            None => cause.label.to_owned(),
        };
        let is_confirmed = |cause: &Cause| {
            let known = |other: &Cause| {
                (other.label, &other.site, &other.partner)
                    == (cause.label, &cause.site, &cause.partner)
            };
            few.diagnosis.causes.iter().any(known)
        };
        let causes = proposed.causes.iter();
        let causes =
            causes.filter(|cause| 0.0 < cause.log_evidence && !is_confirmed(cause)).map(name);
        let pairs = proposed.pairs.iter().skip(effort.pairs);
        let pairs = pairs.map(|pair| pair.causes.each_ref().map(name).join(" with "));
        Self {
            foretold: *explains,
            linearised_with: *runs,
            proposed: proposed.causes.len(),
            confirmed: few.diagnosis.causes.len(),
            left_out: causes.chain(pairs).collect(),
            limits: few.limits,
            budget: request.budget.map(|budget| budget.to_string()),
        }
    }
}
