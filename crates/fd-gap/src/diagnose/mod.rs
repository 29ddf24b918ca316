//! From a model, candidates and logs to an answer.

mod candidates;
mod case;
mod context;
mod feedback;
mod judge;
mod monitor;
mod prepare;
mod report;
mod result;
mod search;
mod settings;
mod weigh;

use self::{
    candidates::Candidates,
    context::Context,
    feedback::Feedback,
    judge::{judge, judged::Judged},
    prepare::{
        Prepared, prepare,
        start::{in_motion, prefer},
    },
    report::report,
    search::search,
    weigh::weigh,
};
pub use self::{
    case::Case,
    monitor::{Monitor, Stage},
    result::{
        Cause, CauseId, Diagnosis, Estimate, Explanation, Group, HeldOut, Leftover, NotTested,
        Nuisance, Pair, PairId, Regime, RivalCause, SideShare, Start, Verdict,
    },
    settings::Settings,
};
use crate::fit::FitError;

/// Diagnoses the gap between a model and logs of the real system.
///
/// ```
/// use fd_effect::Candidate;
/// use fd_gap::diagnose::{Case, Settings, Verdict, diagnose};
/// use fd_sim::model::Model;
/// use fd_model::{Channel, Record};
///
/// let model: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "lag"
/// sample_time = 0.1
/// inputs = { u = { unit = "V" } }
/// outputs = { y = { unit = "V", value = "x", noise = 0.01 } }
/// parameters = { T = { unit = "s", value = 1.0 } }
/// states = { x = { unit = "V", initial = 0.0, derivative = "(u - x)/T" } }
/// "#.parse()?;
/// let (u, y) = ([Channel::new("u", "V")], [Channel::new("y", "V")]);
/// let noise = |k: u32| 0.01 * f64::from(k * 7919 % 13).sin();
/// let x = |k: u32| 1.0 - (-0.1 * f64::from(k)).exp();
/// let rows = (0..100).map(|k| ([1.0], [x(k) + noise(k)]));
/// let log = Record::from_rows(u.to_vec(), y.to_vec(), rows, model.sample_time()?)?;
/// let suspects: Vec<Candidate> = Vec::new();
/// let case = Case { nominal: &model, suspects: &suspects, logs: &[log], held_out: &[] };
/// let diagnosis = diagnose(&case, &Settings::default(), &())?;
/// assert_eq!(diagnosis.verdict, Verdict::NoGap);
/// assert!(0.9 < diagnosis.no_gap);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Returns an error when the model cannot be simulated or does not fit the logs. A candidate that
/// cannot be simulated is no error; see [`Diagnosis::not_tested`].
pub fn diagnose(
    case: &Case<'_>,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Diagnosis, FitError> {
    let feedback = Feedback::of(case, settings.horizon);
    let candidates = Candidates::of(case.suspects);
    let logged = feedback.case(case);
    let context = Context { case: logged, candidates: &candidates, settings, monitor };

    let prepared = prepare(&context.case, settings.horizon)?;
    let free = in_motion(&prepared, &context.case, settings.horizon)?;
    let stated = judged(prepared, &context)?;
    let judged = match free {
        Some(free) => prefer(stated, judged(free, &context)?),
        None => stated,
    };
    report(judged, case, &feedback, &context)
}

/// From prepared logs to a judgement.
fn judged<'a>(prepared: Prepared, context: &Context<'a>) -> Result<Judged<'a>, FitError> {
    let searched = search(prepared, context)?;
    let weighed = weigh(searched, context)?;
    judge(weighed, context)
}
