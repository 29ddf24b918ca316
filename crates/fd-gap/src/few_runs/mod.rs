//! Diagnosis of a simulator that is expensive to run.
//!
//! The same diagnosis is made twice: first with every candidate on a [`StandIn`], the simulator linearised
//! along the logs, which costs no run at all; then on the simulator itself, with the best causes and pairs,
//! each starting from the values found. A step of a fit then costs one run, since the slopes are those of the
//! stand-in. The answer comes from the second diagnosis; the first only proposes.
//!
//! A limit that is not reached by the nominal simulator, or behind one that is, has no slope: no linear model proposes
//! it. Where the answer is "none of these", or ends far above the noise, limits are therefore tried on the simulator
//! itself.
//!
//! *When not to use:* for equations, where [`diagnose()`](crate::diagnose::diagnose()) takes a second. Where
//! the stand-in predicts little ([`FewRuns::explains`]), its proposals are worth little as well, and the first
//! diagnosis has to be made on the simulator.

mod effort;
mod proposals;
mod refit;

use fd_model::SampleTime;
use fd_sim::{
    simulate::{Nominal, Shell},
    stand_in::{Driven, Replay, StandIn},
};

pub use self::effort::Effort;
use self::{proposals::Proposals, refit::Refit};
use crate::{
    diagnose::{
        Beginning, Case, Diagnosis, Explanation, Monitor, Regime, Settings, Stage, Told, Verdict,
        diagnose, told,
    },
    fit::{FitError, Log},
};

/// Share of a disturbance that a stand-in has to foretell before it may propose.
const FORETOLD: f64 = 0.5;

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
    /// Whether limits were tried on the simulator itself.
    pub limits: bool,
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
    let Told { diagnosis: proposed, is_doubted } = told(&proposing, settings, monitor, false)?;
    let causes = Some(proposed.causes.len());
    let mut proposals = Proposals::of(&proposed, case.suspects, effort);
    // What one run shows of a simulator with noise in itself is no better place.
    let repeats = shell.inside().repeats();
    let best = if repeats {
        at_the_best(shell, ts, case, forces, (&stand_in, &proposed.best))?
    } else {
        None
    };
    let mut beginning = if repeats { proposed.beginning() } else { settings.beginning };
    let runs = runs + best.as_ref().map_or(0, StandIn::runs);
    let settings = Settings { causes, ..settings.clone() };
    if let Some(best) = &best {
        // What is near the best answer is fitted better there, and where the logs begin shows better.
        let proposing = Case { nominal: best, suspects: &proposals, logs: &records, held_out: &[] };
        let doubt = if is_doubted { Beginning::Doubted } else { Beginning::AsStated };
        let near = Settings { beginning: doubt, ..settings.clone() };
        let near = told(&proposing, &near, monitor, false)?;
        beginning = near.diagnosis.beginning();
        proposals = Proposals::of(&near.diagnosis, case.suspects, effort);
    }
    let stand_in = best.unwrap_or(stand_in);
    let lent = stand_in.lent();
    let confirming = Case { nominal: &lent, suspects: &proposals, ..*case };
    // To see the simulator with both beginnings would take twice the runs.
    let settings = Settings { beginning, ..settings };
    let diagnosis = diagnose(&confirming, &settings, monitor)?;
    let mut few =
        FewRuns { diagnosis, proposed, explains: stand_in.explains(), runs, limits: false, lent };
    if effort.limits
        && (few.diagnosis.verdict == Verdict::NoneOfThese
            || few.diagnosis.regime == Regime::AboveTheFloor)
        && let Some(found) = limits(shell, case, proposals, &settings, monitor)?
    {
        few.limits = true;
        if evidence(&few.diagnosis) < evidence(&found) {
            (few.diagnosis, few.lent) = (found, shell.clone());
        }
    }
    Ok(Some(few))
}

/// Diagnoses with limits beside what was proposed. Their slopes are those of the simulator itself, of which this takes
/// many more runs. `None` where there are no limits.
fn limits(
    shell: &Shell,
    case: &Case<'_>,
    proposals: Proposals<'_>,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Option<Diagnosis>, FitError> {
    let Some(suspects) = proposals.with_limits() else { return Ok(None) };
    monitor.plan(
        "None of the causes that the linearised simulator proposes explains the logs. Limits, of which that knows \
         nothing, are tried on the simulator itself.",
    );
    let causes = settings.causes.map(|causes| causes + suspects.limits());
    let settings = Settings { causes, ..settings.clone() };
    let case = Case { nominal: shell, suspects: &suspects, ..*case };
    Ok(Some(diagnose(&case, &settings, monitor)?))
}

/// Evidence of the best single cause.
fn evidence(diagnosis: &Diagnosis) -> f64 {
    diagnosis.causes.first().map_or(f64::NEG_INFINITY, |first| first.log_evidence)
}

/// The simulator, linearised along the logs of a case, in the run of a refit.
fn stand_in(
    shell: &Shell,
    ts: SampleTime,
    case: &Case<'_>,
    forces: &[f64],
    refit: Option<&Refit>,
) -> Result<Option<StandIn>, FitError> {
    let logs = Log::all(case.logs, &*shell.simulator(ts)?, &[])?;
    let mut replays = replays(&logs);
    for (i, replay) in replays.iter_mut().enumerate() {
        replay.x0 = refit.map(|refit| refit.starts[i].as_slice());
    }
    let theta = refit.map(|refit| refit.theta.as_slice());
    Ok(StandIn::of(shell, ts, &replays, forces, theta)?)
}

/// The simulator, linearised once more where it is with the best answer of a stand-in: a plant that moves otherwise has
/// other slopes, with respect to its parameters even where it is linear. `None` where the best answer has no effects
/// before the simulator, or it cannot be linearised there.
fn at_the_best(
    shell: &Shell,
    ts: SampleTime,
    case: &Case<'_>,
    forces: &[f64],
    (known, best): (&StandIn, &Explanation),
) -> Result<Option<StandIn>, FitError> {
    let simulator = shell.simulator(ts)?;
    let logs = Log::all(case.logs, &*simulator, &[])?;
    let mut replays = replays(&logs);
    let starts = best.starts.iter().filter(|start| start.from == 0);
    if starts.clone().count() != replays.len() || shell.passes_on(&best.model)? {
        return Ok(None);
    }
    for start in starts {
        if let Some(replay) = replays.get_mut(start.log) {
            replay.x0 = Some(&start.state);
        }
    }
    let driven =
        replays.iter().enumerate().map(|(i, replay)| known.driven(&best.model, ts, i, replay));
    let driven: Option<Vec<Driven>> = driven.collect::<Result<_, _>>()?;
    let Some(driven) = driven else { return Ok(None) };
    for (replay, driven) in replays.iter_mut().zip(&driven) {
        replay.driven = Some(driven);
    }
    let theta = driven.first().map(|driven| driven.theta.as_slice());
    let found = StandIn::of(shell, ts, &replays, forces, theta)?;
    Ok(found.filter(|found| FORETOLD <= found.explains()))
}

fn replays(logs: &[Log]) -> Vec<Replay<'_>> {
    let each = logs.iter().map(|log| Replay {
        u: &log.u,
        samples: log.samples,
        first: log.first as u64,
        x0: None,
        driven: None,
    });
    each.collect()
}
