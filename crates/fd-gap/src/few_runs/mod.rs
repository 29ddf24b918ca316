//! Diagnosis of a simulator that is expensive to run.
//!
//! The same diagnosis is made twice: first with every candidate on a [`StandIn`], the simulator linearised
//! along the logs, which costs no run at all; then on the simulator itself, with the best causes and pairs,
//! each starting from the values found. A step of a fit then costs one run, since the slopes are those of the
//! stand-in. The answer comes from the second diagnosis; the first only proposes.
//!
//! *When not to use:* for equations, where [`diagnose()`](crate::diagnose::diagnose()) takes a second. Where
//! the stand-in predicts little ([`FewRuns::explains`]), its proposals are worth little as well, and the first
//! diagnosis has to be made on the simulator.

mod proposals;
mod refit;

use fd_model::SampleTime;
use fd_sim::{
    simulate::{Nominal, Shell},
    stand_in::{Replay, StandIn},
};

use self::{proposals::Proposals, refit::Refit};
use crate::{
    diagnose::{Case, Diagnosis, Monitor, Settings, Stage, diagnose},
    fit::{FitError, Log},
};

/// Share of a disturbance that a stand-in has to foretell before it may propose.
const FORETOLD: f64 = 0.5;

/// How much is confirmed on the simulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Effort {
    /// Most single causes, halves of pairs not counted.
    pub causes: usize,
    /// Most pairs of causes.
    pub pairs: usize,
}

impl Default for Effort {
    fn default() -> Self {
        Self { causes: 8, pairs: 3 }
    }
}

/// A diagnosis with few runs of the simulator.
#[derive(Clone, Debug)]
pub struct FewRuns {
    /// What the simulator says of the causes that were proposed.
    pub diagnosis: Diagnosis,
    /// What the stand-in says of all causes.
    pub proposed: Diagnosis,
    /// Share of a disturbance that the stand-in foretells.
    pub explains: f64,
    /// Runs of all logs that the stand-in was made of.
    pub runs: usize,
    /// The simulator in its shell, with the slopes of the stand-in: for whatever is asked of these logs next.
    pub lent: Shell,
}

/// Diagnoses a simulator in its shell with few runs; `suspects` are those of the shell, and `forces` typical forces at
/// its ports. `None` where there is no stand-in for the simulator, or one that foretells too little: then
/// [`diagnose()`](crate::diagnose::diagnose()) is the way.
///
/// # Errors
///
/// As [`diagnose()`](crate::diagnose::diagnose()).
pub fn with_few_runs(
    shell: &Shell,
    forces: &[f64],
    case: &Case<'_>,
    settings: &Settings,
    effort: Effort,
    monitor: &dyn Monitor,
) -> Result<Option<FewRuns>, FitError> {
    let ts = case.logs.first().ok_or(FitError::NoLog)?.ts();
    monitor.begin(Stage::StandIn, 2);
    let Some(nominal) = stand_in(shell, ts, case, forces, None)? else { return Ok(None) };
    monitor.advance();
    if nominal.explains() < FORETOLD {
        return Ok(None);
    }
    let refit = Refit::of(&Case { nominal: &nominal.lent(), ..*case }, settings)?;
    let again = match refit {
        Some(refit) => stand_in(shell, ts, case, forces, Some(&refit))?,
        None => None,
    };
    let runs = nominal.runs() + again.as_ref().map_or(0, StandIn::runs);
    let stand_in = again.unwrap_or(nominal);
    monitor.advance();
    let records = case.logs.iter().enumerate().map(|(i, record)| stand_in.record(i, record));
    // A log with a channel of that name has no stand-in.
    let Ok(records) = records.collect::<Result<Vec<_>, _>>() else { return Ok(None) };
    let proposing = Case { nominal: &stand_in, logs: &records, held_out: &[], ..*case };
    let proposed = diagnose(&proposing, settings, monitor)?;
    let proposals = Proposals::of(&proposed, case.suspects, effort);
    let lent = stand_in.lent();
    let confirming = Case { nominal: &lent, suspects: &proposals, ..*case };
    let settings = Settings { causes: Some(proposed.causes.len()), ..settings.clone() };
    let diagnosis = diagnose(&confirming, &settings, monitor)?;
    let explains = stand_in.explains();
    Ok(Some(FewRuns { diagnosis, proposed, explains, runs, lent }))
}

/// The simulator, linearised along the logs of a case.
fn stand_in(
    shell: &Shell,
    ts: SampleTime,
    case: &Case<'_>,
    forces: &[f64],
    refit: Option<&Refit>,
) -> Result<Option<StandIn>, FitError> {
    let logs = Log::all(case.logs, &*shell.simulator(ts)?, &[])?;
    let mut replays = Vec::with_capacity(logs.len());
    for (i, log) in logs.iter().enumerate() {
        let x0 = refit.map(|refit| refit.starts[i].as_slice());
        replays.push(Replay { u: &log.u, samples: log.samples, first: log.first as u64, x0 });
    }
    let theta = refit.map(|refit| refit.theta.as_slice());
    Ok(StandIn::of(shell, ts, &replays, forces, theta)?)
}
