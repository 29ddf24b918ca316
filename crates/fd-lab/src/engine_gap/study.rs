//! One withheld cause, two simulators that lack it: which of them names it?

use fd_effect::{Effect, EverySite};
use fd_gap::diagnose::{Case, Cause, Diagnosis, Settings, Verdict, diagnose};
use fd_model::Record;
use fd_sim::simulate::Nominal;
use fdiag::engine_plant::EnginePlantError;

use super::EngineCause;

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
    let u: Vec<f64> = log.samples().flat_map(|(u, _)| u.to_vec()).collect();
    let scales = nominal.scales(log.ts(), &u, log.len())?;
    let suspects = EverySite::new(effects, nominal.model(), scales);
    let logs = std::slice::from_ref(log);
    let case = Case { nominal, suspects: &suspects, logs, held_out: &[] };
    Ok(diagnose(&case, &Settings::default(), &())?)
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
