//! From a model, the effects that it may lack, and logs of the real system to an answer: which effect is
//! missing, where, how strong it is, and how certain that is.
//!
//! # What it answers
//!
//! *Is there a gap at all*, once the uncertain parameters have been refitted? *Which cause* (an effect at a
//! site, all its laws together), or which two, explain it, with what probability, and which others can this log
//! not tell from them? *Is it none of these?* *How far does the gap shrink* on logs that no fit has seen? A
//! [`Diagnosis`] contains all of this; [`Diagnosis::verdict`] is the answer in one word.
//!
//! # What it needs
//!
//! A simulator ([`Nominal`](fd_sim::simulate::Nominal)) with tolerances of its parameters, as honest as
//! possible: whatever a tolerance allows is not a gap. Suspects ([`Suspects`](fd_effect::Suspects)), usually
//! every effect of the library at every site. One log that excites everything, with at least some hundred
//! samples, and a second one to forecast ([`Case::held_out`]): a wrong law may fit, but it does not forecast.
//! The noise: where a model does not state it, it is estimated, and the answers are less certain.
//!
//! # How long it takes
//!
//! About a hundred candidates on 1000 samples of a plant with a few states take a second (median of 700 blind
//! cases: 0.92 s on one core, nine of ten below 2.8 s); nearly all of it is spent on simulations, and
//! candidates are distributed over threads. The answer does not depend on the number of threads.
//!
//! # When not to trust it
//!
//! * Where [`Diagnosis::findings`] say that the log is defective: repair that first.
//! * Where the verdict is [`Verdict::Tied`]: the data cannot decide, and the order of the tied causes means
//!   nothing. [`experiment`](mod@crate::experiment) says what would decide.
//! * Where [`Regime::AboveTheFloor`] is reported: nothing comes near the noise, as on most real logs. The named
//!   cause is then the largest, but hardly the only one; [`road`](mod@crate::road) continues from it.
//! * Where there are [`Diagnosis::objections`]. Vetoes among them have already removed the named cause.
//! * Where the log is poorly excited, or the loop is tight: a gap that does not show has no cause.
//! * Where the exact probabilities matter: they are calibrated on simulated plants;
//!   [`calibrate`](mod@crate::calibrate) does it for one log.
//!
//! # An example
//!
//! A lag whose actuator does not respond below 0.3 V, which is missing in the model:
//!
//! ```
//! use fd_effect::{EverySite, library};
//! use fd_gap::diagnose::{Case, Settings, Verdict, diagnose};
//! use fd_model::{Channel, Record};
//! use fd_sim::{model::Model, scales::ReplayScales};
//!
//! let model: Model = r#"
//! version = 1
//! kind = "equations"
//! name = "lag"
//! sample_time = 0.1
//! inputs = { u = { unit = "V" } }
//! outputs = { y = { unit = "V", value = "x", noise = 0.01 } }
//! parameters = { T = { unit = "s", value = 1.0, tolerance = 0.05 } }
//! states = { x = { unit = "V", initial = 0.0, derivative = "(u - x)/T" } }
//! "#.parse()?;
//! let command = |k: usize| (0.13 * k as f64).sin() + 0.6 * (0.037 * k as f64).cos();
//! let (mut x, mut random) = (0.0, 1_u32);
//! let rows: Vec<([f64; 1], [f64; 1])> = (0..400)
//!     .map(|k| {
//!         // Noise of 0.01 V, by the generator of Marsaglia (2003).
//!         random ^= random << 13;
//!         random ^= random >> 17;
//!         random ^= random << 5;
//!         let noise = 0.01 * 12.0_f64.sqrt() * (f64::from(random) / f64::from(u32::MAX) - 0.5);
//!         let (u, y) = (command(k), x + noise);
//!         let acts = u - u.clamp(-0.3, 0.3);
//!         x = acts + (x - acts) * (-0.1_f64).exp();
//!         ([u], [y])
//!     })
//!     .collect();
//! let (inputs, outputs) = (vec![Channel::new("u", "V")], vec![Channel::new("y", "V")]);
//! let ts = model.sample_time()?;
//! let log = Record::from_rows(inputs, outputs, rows, ts)?;
//!
//! let u: Vec<f64> = (0..400).map(command).collect();
//! let scales = ReplayScales::of(&model, ts, &u, 400)?;
//! let suspects = EverySite::new(library(), &model, scales);
//! let case = Case { nominal: &model, suspects: &suspects, logs: &[log], held_out: &[] };
//! let diagnosis = diagnose(&case, &Settings::default(), &())?;
//!
//! let first = &diagnosis.causes[0];
//! assert_eq!((diagnosis.verdict, first.label), (Verdict::Cause, "input-dead-zone"));
//! let width = &first.parameters[0];
//! assert!((width.value - 0.3).abs() < 4.0 * width.standard_error + 0.01);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The steps
//!
//! Each step is a value that one function makes from the one before and that does not change afterwards;
//! [`diagnose()`] makes these calls in sequence.
//!
//! | step | made by | what is in it | directory |
//! |---|---|---|---|
//! | [`Case`] | the caller | simulator, suspects, logs | `case.rs` |
//! | `Prepared` | `prepare` | logs cut to the horizon, the noise, the fit of the nuisances without any effect | `prepare/` |
//! | `Searched` | `search` | every candidate scored at every start, what promises something fitted roughly, the best causes fitted fully, with a sufficiently short integration step | `search/` |
//! | `Weighed` | `weigh` | evidence of single causes and of pairs, with the colour of the noise; the best answer, chosen from the refitted model, the first cause and the first pair | `weigh/` |
//! | `Judged` | `judge` | ties, doubts, probabilities, the verdict; by evidence, or by forecasts where nothing comes near the noise | `judge/` |
//! | [`Diagnosis`] | `report` | the answer for people, with the loop closed, the noise floor and held-out gaps | `report/` |
//!
//! Before the first step, `feedback.rs` decides whether the controller in the loop saw the logged outputs; if
//! so, it is run on these ([`LoggedLoop`](fd_sim::simulate::LoggedLoop)). Logs that seem to begin in motion are
//! prepared twice, with stated and with free initial states, and go through all steps to `Judged` twice; the
//! judgement with stated initial states is kept unless the other one explains clearly more. `sets/` fits several
//! effects together, here two, and for [`road`](mod@crate::road) as many as there are.
//!
//! # Where a rule goes
//!
//! | a rule about | belongs in |
//! |---|---|
//! | what the noise is taken to be, what is near it and what is far above it | `prepare/noise.rs` |
//! | where the states of a log begin | `prepare/start.rs`, `judge/starts.rs` |
//! | where fits start, and which candidates deserve one | `search/base.rs`, `search/screen.rs`, `search/trial.rs`, `search/finalists.rs` |
//! | which candidates are looked at again beside others | `search/changes.rs` |
//! | when second causes are tried, and when noise gets a colour | `weigh/mod.rs`, `weigh/colour.rs` |
//! | what must speak for a pair before it is preferred | `weigh/answer.rs` (`choose`) |
//! | a corrupted measurement: outliers, rounding, more noise | `weigh/measurement.rs` |
//! | single wrong samples, which are left out | `accidents.rs`, [`quality`](mod@crate::quality) |
//! | what a good explanation may leave | `weigh/leftover.rs`, `weigh/lack_of_fit.rs` |
//! | ties: what a log cannot tell apart | `judge/ties.rs`, `judge/pair_ties.rs` |
//! | what puts an answer in doubt | `judge/by_evidence.rs`, `judge/missed.rs`, `judge/probabilities.rs` |
//! | what an engineer would object to at first sight, and vetoes | `report/objections.rs` |
//! | forecasts that judge instead of evidence, and how far a law is believed then | `judge/contest.rs` |
//! | horizons | `judge/horizons.rs` |
//! | free runs that are lost, and fits that go through windows | `judge/through_windows.rs` |
//! | the answer in one word | `judge/verdict.rs` |
//! | the floor that a gap is measured from | `report/reported_floor.rs` |
//! | findings about a log, and how they read | `report/findings.rs`, [`quality`](mod@crate::quality) |
//!
//! `docs/constants.md` lists the numbers in these rules and how they were set.

mod accidents;
mod adjustable;
mod candidates;
mod case;
mod commanded;
mod context;
mod feedback;
mod judge;
mod monitor;
mod objection;
mod prepare;
mod report;
mod result;
mod search;
mod sets;
mod settings;
mod weigh;

use self::{
    accidents::Accidents,
    candidates::Candidates,
    context::Context,
    feedback::Feedback,
    judge::{is_open, is_settled, judge, judged::Judged, prefer},
    prepare::{Prepared, start::in_motion},
    report::report,
    search::{search, trial::Trial},
    weigh::weigh,
};
pub use self::{
    adjustable::adjustable,
    case::Case,
    commanded::commanded,
    feedback::saw_the_log,
    monitor::{Monitor, Stage},
    objection::Objection,
    result::{
        Cause, CauseId, Diagnosis, Estimate, Explanation, Group, HeldOut, Leftover, NotTested,
        Nuisance, Pair, PairId, Regime, RivalCause, SideShare, Start, Verdict,
    },
    sets::{EffectSet, SetSearch, Wanted},
    settings::{Beginning, ControllerSees, Settings, Without},
};
pub(crate) use self::{
    candidates::{follows_anything, is_curve_of_signal, is_law, wanders},
    judge::NAMED,
    prepare::prepare,
    report::objections::FAINT,
    sets::Round,
    settings::LEADING,
    weigh::answer::is_a_pair,
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
    Ok(told(case, settings, monitor, false)?.diagnosis)
}

/// A diagnosis, and where it took the logs to begin.
pub(crate) struct Told {
    pub diagnosis: Diagnosis,
    /// Whether both beginnings were tried.
    pub is_doubted: bool,
}

/// One diagnosis, and another one without single wrong samples if it shows any, unless the logs are `clean` of them.
pub(crate) fn told(
    case: &Case<'_>,
    settings: &Settings,
    monitor: &dyn Monitor,
    clean: bool,
) -> Result<Told, FitError> {
    let feedback = Feedback::of(case, settings);
    let candidates = Candidates::of(case.suspects);
    let logged = feedback.case(case);
    let prepared = prepare(&logged, settings.horizon)?;
    let tempered = prepared.with_chance(settings);
    let context = Context { case: logged, candidates: &candidates, settings: &tempered, monitor };
    let free = in_motion(&prepared, &context.case, settings)?;
    let is_doubted = free.is_some();
    let judged = match (free, settings.beginning) {
        (Some(free), Beginning::InMotion) => judged(free, &[], &context)?,
        (Some(free), _) => {
            let searched = search(prepared, &[], &context)?;
            if is_settled(&searched, &free)? {
                judged(free, &searched.trials, &context)?
            } else {
                let stated = judge(weigh(searched, &context)?, &context)?;
                if is_open(&stated, &free) {
                    let free = judged(free, &stated.singles.searched.trials, &context)?;
                    prefer(stated, free)
                } else {
                    stated
                }
            }
        }
        (None, _) => judged(prepared, &[], &context)?,
    };
    let accidents = if clean { None } else { Accidents::of(&judged, case) };
    let Some(Accidents { findings, logs }) = accidents else {
        let diagnosis = report(judged, &feedback.plain(case), &feedback, &context)?;
        return Ok(Told { diagnosis, is_doubted });
    };
    let before = report::simulations(&judged);
    let mut again = told(&Case { logs: &logs, ..*case }, settings, monitor, true)?;
    again.diagnosis.findings.extend(findings);
    again.diagnosis.simulations += before;
    again.diagnosis.cleaned = Some(logs);
    Ok(again)
}

/// From prepared logs to a judgement; laws that are `known` from other starts of the logs are begun from there, too.
fn judged<'a>(
    prepared: Prepared,
    known: &[Trial<'a>],
    context: &Context<'a>,
) -> Result<Judged<'a>, FitError> {
    let searched = search(prepared, known, context)?;
    let weighed = weigh(searched, context)?;
    judge(weighed, context)
}
