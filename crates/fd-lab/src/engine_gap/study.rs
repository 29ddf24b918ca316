//! One withheld cause, two simulators that lack it: which of them names it?

use fd_effect::{Effect, EverySite};
use fd_gap::{
    diagnose::{Case, Cause, Diagnosis, Settings, Verdict, diagnose},
    few_runs::{Effort, FewRuns, with_few_runs},
};
use fd_model::Record;
use fd_sim::simulate::{Nominal, SimulateError};
use fdiag::engine_plant::{
    ENGINE_KIND, EngineKnowledge, EnginePlantError, EngineSimulator, engine_noise,
};

use super::EngineCause;
use crate::black_box::{BlackBox, Sight};

/// Diagnoses a log with a list of effects.
///
/// # Errors
///
/// Returns an error when the simulator cannot be run or does not fit the log.
pub fn diagnose_engine(
    nominal: &dyn Nominal,
    effects: Vec<Box<dyn Effect>>,
    log: &Record,
) -> Result<Diagnosis, EnginePlantError> {
    let suspects = suspects(nominal, effects, log)?;
    let logs = std::slice::from_ref(log);
    let case = Case { nominal, suspects: &suspects, logs, held_out: &[] };
    Ok(diagnose(&case, &Settings::default(), &())?)
}

/// A diagnosis of the nonlinear engine as a black box, and what it has cost.
#[derive(Clone, Debug)]
pub struct FewRunsOfEngine {
    /// What the engine says of the causes that its linear stand-in proposes.
    pub diagnosis: Diagnosis,
    /// Runs of the engine through the log.
    pub runs: f64,
}

/// The same with few runs of the nonlinear engine, which shows its states and steps. `None` where its stand-in foretells
/// too little.
///
/// # Errors
///
/// As [`diagnose_engine`].
pub fn diagnose_with_few_runs(
    known: &EngineKnowledge,
    effects: Vec<Box<dyn Effect>>,
    log: &Record,
) -> Result<Option<FewRunsOfEngine>, EnginePlantError> {
    let black_box = engine_as_black_box(known, engine_noise(known)?)?;
    let shell = black_box.shell()?;
    let suspects = suspects(&shell, effects, log)?;
    let logs = std::slice::from_ref(log);
    let case = Case { nominal: &shell, suspects: &suspects, logs, held_out: &[] };
    let few = with_few_runs(&shell, &[], &case, &Settings::default(), Effort::default(), &())?;
    Ok(few.map(|FewRuns { diagnosis, .. }| FewRunsOfEngine {
        diagnosis,
        runs: black_box.runs(log.len()),
    }))
}

/// The nonlinear engine as a simulator that steps and shows its states, with the noise of its outputs.
pub(crate) fn engine_as_black_box(
    known: &EngineKnowledge,
    noise: Vec<Option<f64>>,
) -> Result<BlackBox, EnginePlantError> {
    let engine = Box::new(EngineSimulator::new(known)?);
    Ok(BlackBox::of(ENGINE_KIND, engine, noise, Vec::new(), Sight::States)?)
}

fn suspects<'a>(
    nominal: &'a dyn Nominal,
    effects: Vec<Box<dyn Effect>>,
    log: &Record,
) -> Result<EverySite<'a>, SimulateError> {
    let u: Vec<f64> = log.samples().flat_map(|(u, _)| u.to_vec()).collect();
    let scales = nominal.scales(log.ts(), &u, log.len())?;
    Ok(EverySite::new(effects, nominal.model(), scales))
}

/// How right an answer is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// The cause alone, or rightly no gap.
    Right,
    /// The cause is among those that are said to be the same for this log.
    Tied,
    /// Not sure; the cause comes first all the same.
    First,
    /// Not sure, and the cause does not come first.
    Unsure,
    /// A gap that is there is said not to be.
    Missed,
    /// Something else is named.
    Wrong,
}

impl Answer {
    /// What a diagnosis makes of a cause.
    #[must_use]
    pub fn of(diagnosis: &Diagnosis, cause: EngineCause) -> Self {
        let (label, site) = cause.name();
        let is_it = |cause: &Cause| cause.label == label && cause.site.name() == Some(site);
        let is_first = diagnosis.causes.first().is_some_and(is_it);
        let mut tied = diagnosis.tied.iter().filter_map(|id| diagnosis.cause(*id));
        match diagnosis.verdict {
            Verdict::NoGap if cause == EngineCause::Nothing => Self::Right,
            Verdict::NoGap => Self::Missed,
            Verdict::Cause if is_first => Self::Right,
            Verdict::Tied if tied.any(is_it) => Self::Tied,
            Verdict::Unclear | Verdict::NoneOfThese if is_first => Self::First,
            Verdict::Unclear | Verdict::NoneOfThese => Self::Unsure,
            Verdict::Cause | Verdict::Tied | Verdict::Pair => Self::Wrong,
        }
    }
}
