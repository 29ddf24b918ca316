//! One withheld cause, two simulators that lack it: which of them names it?

use fd_effect::{Effect, EverySite};
use fd_gap::diagnose::{Case, Diagnosis, Settings, Verdict, diagnose};
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
        let is_it = |place: usize| {
            let cause = diagnosis.causes.get(place);
            cause.is_some_and(|c| c.label == label && c.site.name() == Some(site))
        };
        match diagnosis.verdict {
            Verdict::NoGap if cause == EngineCause::Nothing => Self::Right,
            Verdict::NoGap => Self::Missed,
            Verdict::Cause if is_it(0) => Self::Right,
            Verdict::Tied if diagnosis.tied.iter().any(|place| is_it(*place)) => Self::Tied,
            Verdict::Unclear | Verdict::NoneOfThese if is_it(0) => Self::First,
            Verdict::Unclear | Verdict::NoneOfThese => Self::Unsure,
            Verdict::Cause | Verdict::Tied | Verdict::Pair => Self::Wrong,
        }
    }
}
