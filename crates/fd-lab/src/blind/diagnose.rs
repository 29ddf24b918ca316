//! The one place where the blind test calls the diagnosis.

use std::time::Instant;

use fd_effect::{
    Candidate, EverySite, Side, Suspects, library, with_default_sites, with_inner_places,
};
use fd_gap::{
    diagnose::{self, Cause, Diagnosis, Pair, Settings, Verdict, diagnose},
    few_runs::{Effort, with_few_runs},
    fit::Horizon,
    inside::inside,
    reading::{self as gap, Mistake, Suspicion, glance, suspect},
    road::{CauseList, road},
};
use fd_model::Record;
use fd_sim::{
    model::Model,
    simulate::{EquationSimulator, Nominal},
};
use fdiag::gap_study::follow;

use super::{
    answer::{Answer, Named, Reading, Share, Together, UNCLEAR},
    error::BlindError,
    feature::{Feature, Method},
};
use crate::black_box::{BlackBox, Sight};

/// Causes that are kept in an answer.
const KEPT: usize = 20;
/// Most causes that are sought one after another, as for a user.
const MOST: usize = 8;
/// Weight of what is left above the floor, against the probability of "none of these".
const TIE_BREAK: f64 = 1e-3;

/// How a case is diagnosed.
struct Approach {
    settings: Settings,
    method: Method,
    /// Whether the plant is followed along its logs.
    is_followed: bool,
}

/// Diagnoses a case as a user would, but for what the method is without.
pub(super) fn answer(
    name: &str,
    model: &Model,
    train: &Record,
    held_out: &Record,
    settings: &Settings,
    method: Method,
) -> Result<Answer, BlindError> {
    let begun = Instant::now();
    let model = with_default_sites(model);
    let (mut logs, mut held_out) = ([train.clone()], [held_out.clone()]);
    let mut settings = method.settings(settings);
    let follower = if method.has(Feature::Following) { follow(&model, &logs)? } else { None };
    let nominal: &dyn Nominal = match &follower {
        Some(follower) => {
            for record in logs.iter_mut().chain(&mut held_out) {
                // A record of this model can be followed.
                if let Ok(followed) = follower.record(record) {
                    *record = followed;
                }
            }
            settings.horizon = Horizon::FreeRun;
            settings.report_horizons = vec![Horizon::FreeRun];
            follower
        }
        None => &model,
    };
    let approach = &Approach { settings, method, is_followed: follower.is_some() };
    let reads_on = !approach.is_followed && method.has(Feature::Readings);
    let read = || diagnosed(nominal, &model, &logs, &held_out, approach);
    let none: Vec<Candidate> = Vec::new();
    let case =
        diagnose::Case { nominal: &model, suspects: &none, logs: &logs, held_out: &held_out };
    let at_once = if reads_on { glanced(&case, approach) } else { None };
    let as_read = at_once.is_none().then(read);
    let mended = match &as_read {
        Some(as_read) if reads_on => mended(&case, approach, as_read.as_ref().ok()),
        _ => at_once,
    };
    let (reading, Diagnosed { diagnosis, candidates, .. }, road) = if let Some(mended) = mended {
        let Mended { reading, model, logs, held_out, diagnosed } = mended;
        let road = diagnosed.road(&model, &model, &logs, &held_out, approach)?;
        (readings(&reading), diagnosed, road)
    } else {
        let as_read = as_read.unwrap_or_else(read)?;
        let road = as_read.road(nominal, &model, &logs, &held_out, approach)?;
        (Vec::new(), as_read, road)
    };
    let seconds = begun.elapsed().as_secs_f64();
    Ok(Answer { reading, seconds, candidates, ..told(name, &diagnosis, road.as_ref()) })
}

/// How a plant is diagnosed as a black box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Manner {
    /// With as many runs as equations are.
    Thorough,
    /// With few runs.
    Sparing(Sight),
}

/// Diagnoses a case of which the plant is a black box.
pub(super) fn as_black_box(
    name: &str,
    model: &Model,
    logs: &[Record; 2],
    settings: &Settings,
    manner: Manner,
) -> Result<Answer, BlindError> {
    let begun = Instant::now();
    let [train, held_out] = logs;
    let ts = train.ts();
    let sight = match manner {
        Manner::Thorough => Sight::States,
        Manner::Sparing(sight) => sight,
    };
    let model = with_default_sites(model);
    let plant = EquationSimulator::<f64>::with_ports(&model, ts)?;
    let black_box = BlackBox::of_equations(&model, plant, sight)?;
    let shell = &black_box.shell()?;
    let (samples, u) = (train.len(), inputs(train));
    let scales = shell.scales(ts, &u, samples)?;
    let forces: Vec<f64> = scales.sites.iter().map(|site| site.force).collect();
    let suspects = EverySite::new(library(), shell.model(), scales);
    let candidates = suspects.alone().iter().flatten().count();
    let logs = std::slice::from_ref(train);
    let held_out = std::slice::from_ref(held_out);
    let case = diagnose::Case { nominal: shell, suspects: &suspects, logs, held_out };
    let few = match manner {
        Manner::Thorough => None,
        Manner::Sparing(_) => {
            with_few_runs(shell, &forces, &case, settings, Effort::default(), &())?
        }
    };
    let diagnosis = match few {
        Some(few) => few.diagnosis,
        None => diagnose(&case, settings, &())?,
    };
    let seconds = begun.elapsed().as_secs_f64();
    let runs = Some(black_box.runs(samples));
    // A shell is no file that could be simulated.
    let told = told(name, &diagnosis, None);
    Ok(Answer { seconds, candidates, runs, patched: None, closed: None, ..told })
}

/// The inputs of a record, row by row.
fn inputs(record: &Record) -> Vec<f64> {
    (0..record.len()).flat_map(|k| record.u(k).to_vec()).collect()
}

/// A diagnosis as an answer.
fn told(name: &str, diagnosis: &Diagnosis, road: Option<&CauseList>) -> Answer {
    let above = diagnosis.best.gap.iter().zip(&diagnosis.floor).map(|(gap, f)| (gap / f).ln());
    let physical = |gaps: &[f64]| -> Vec<f64> {
        gaps.iter().zip(&diagnosis.sigma).map(|(gap, sigma)| gap * sigma).collect()
    };
    let list = road.filter(|road| 1 < road.causes.len());
    let together = match (list, diagnosis.verdict, diagnosis.pairs.first()) {
        (Some(list), ..) => list.causes.iter().map(|listed| named(&listed.cause)).collect(),
        (_, Verdict::Pair, Some(pair)) => pair.causes.iter().map(named).collect(),
        _ => Vec::new(),
    };
    let refit = diagnosis.refit.nuisances.iter().map(|n| (n.name.clone(), n.value));
    // A path that was drawn anew through a log forecasts nothing of another.
    let forecast = diagnosis.forecast().filter(|held_out| !held_out.is_redrawn);
    let closed = forecast.and_then(|held_out| held_out.closed_of_refit);
    // A list closes what all of it does.
    let closed = list.map_or(closed, |list| list.closed);
    let patched = list.map_or(&diagnosis.best.model, |list| &list.model);
    let outputs = diagnosis.best.model.outputs.iter().zip(&diagnosis.steps);
    let rounded = outputs.filter(|(_, step)| step.is_some()).map(|(output, _)| output.name.clone());
    Answer {
        case: name.to_owned(),
        verdict: verdict(diagnosis.verdict).to_owned(),
        no_gap: diagnosis.no_gap,
        // Its probability; what is left above the floor breaks ties.
        none_score: diagnosis.none_of_these + TIE_BREAK * above.fold(0.0, f64::max),
        says_none: diagnosis.verdict == Verdict::NoneOfThese,
        causes: diagnosis.causes.iter().take(KEPT).map(named).collect(),
        tied: diagnosis.tied.iter().map(|id| id.0).collect(),
        together,
        pairs: diagnosis.pairs.iter().take(KEPT).map(together_with).collect(),
        gaps: [&diagnosis.refit.gap, &diagnosis.best.gap, &diagnosis.floor]
            .map(|gaps| physical(gaps)),
        sigma: diagnosis.sigma.clone(),
        rounded: rounded.collect(),
        closed: closed.map(|c| Share { fraction: c.fraction, interval: c.interval }),
        refit: refit.collect(),
        patched: Some(patched.to_string()),
        ..Answer::default()
    }
}

/// A diagnosis and the number of its candidates.
struct Diagnosed {
    diagnosis: Diagnosis,
    candidates: usize,
    /// Whether it names an effect inside the model.
    is_inside: bool,
}

impl Diagnosed {
    /// Several causes, where the diagnosis asks for them; those of the logs and the `nominal` simulator that it is of.
    fn road(
        &self,
        nominal: &dyn Nominal,
        model: &Model,
        logs: &[Record],
        held_out: &[Record],
        approach: &Approach,
    ) -> Result<Option<CauseList>, BlindError> {
        let has_lists = approach.method.has(Feature::Lists) && !self.is_inside;
        let Some(train) = logs.first().filter(|_| has_lists) else { return Ok(None) };
        let scales = nominal.scales(train.ts(), &inputs(train), train.len())?;
        let suspects = EverySite::new(approach.method.library(), model, scales);
        let case = diagnose::Case { nominal, suspects: &suspects, logs, held_out };
        Ok(road(&case, &self.diagnosis, &approach.settings, MOST, &())?)
    }
}

/// A mistake of reading, and what a diagnosis says once it is mended.
struct Mended {
    reading: gap::Reading,
    model: Model,
    logs: Vec<Record>,
    held_out: Vec<Record>,
    diagnosed: Diagnosed,
}

/// Diagnoses logs with a simulator of the `model`; with effects inside it where one of them explains them clearly better.
fn diagnosed(
    nominal: &dyn Nominal,
    model: &Model,
    logs: &[Record],
    held_out: &[Record],
    approach: &Approach,
) -> Result<Diagnosed, BlindError> {
    let Approach { settings, method, is_followed } = approach;
    let Some(train) = logs.first() else { return Err(fd_gap::fit::FitError::NoLog.into()) };
    let u = inputs(train);
    let scales = nominal.scales(train.ts(), &u, train.len())?;
    let suspects = EverySite::new(method.library(), model, scales);
    let candidates = suspects.alone().iter().flatten().count();
    let case = diagnose::Case { nominal, suspects: &suspects, logs, held_out };
    let diagnosis = diagnose(&case, settings, &())?;
    let looks_inside = !is_followed && method.has(Feature::InnerPlaces);
    if looks_inside && diagnosis.verdict != Verdict::NoGap {
        let inner = with_inner_places(model);
        let scales = inner.scales(train.ts(), &u, train.len())?;
        let scales = scales.with_signals(&inner, train.ts(), &u, train.len())?;
        let suspects = EverySite::new(method.library(), &inner, scales);
        let case = diagnose::Case { nominal: &inner, suspects: &suspects, logs, held_out };
        if let Ok(Some(diagnosis)) = inside(&case, &diagnosis, settings, &()) {
            let candidates = suspects.alone().iter().flatten().count();
            return Ok(Diagnosed { diagnosis, candidates, is_inside: true });
        }
    }
    Ok(Diagnosed { diagnosis, candidates, is_inside: false })
}

/// The diagnosis of the mended log, where a mistake of reading is confirmed. The case has no suspects.
fn mended(
    case: &diagnose::Case<'_>,
    approach: &Approach,
    as_read: Option<&Diagnosed>,
) -> Option<Mended> {
    let as_read = as_read.map(|diagnosed| &diagnosed.diagnosis);
    Mended::of(suspect(case, approach.settings.horizon, as_read).ok()??, case, approach)
}

/// The same with a mistake that is seen before any cause is tried, and leaves no gap.
fn glanced(case: &diagnose::Case<'_>, approach: &Approach) -> Option<Mended> {
    let suspicion = glance(case, approach.settings.horizon).ok()??;
    let mended = Mended::of(suspicion, case, approach)?;
    (mended.diagnosed.diagnosis.verdict == Verdict::NoGap).then_some(mended)
}

impl Mended {
    /// The diagnosis of the mended log, if that confirms what is suspected.
    fn of(suspicion: Suspicion, case: &diagnose::Case<'_>, approach: &Approach) -> Option<Self> {
        let model = suspicion.mistake().mended_model(case.nominal.model())?;
        let (logs, held_out) = (suspicion.mended(case.logs)?, suspicion.mended(case.held_out)?);
        let diagnosed = diagnosed(&model, &model, &logs, &held_out, approach).ok()?;
        let case = diagnose::Case { nominal: &model, logs: &logs, held_out: &held_out, ..*case };
        let reading = suspicion.judged(&case, &diagnosed.diagnosis)?;
        Some(Self { reading, model, logs, held_out, diagnosed })
    }
}

/// What was named, and what cannot be told from it.
fn readings(reading: &gap::Reading) -> Vec<Reading> {
    let of = |mistake: &Mistake, is_tied| {
        let (kind, factor, late) = match mistake {
            Mistake::Sign { .. } => ("sign", None, None),
            Mistake::Unit { factor, .. } => ("unit", Some(*factor), None),
            Mistake::Zero { .. } => ("zero", None, None),
            Mistake::CutOff { .. } => ("cut-off", None, None),
            Mistake::Swap { .. } => ("swap", None, None),
            Mistake::Clock { late, .. } => ("clock", None, Some(*late as f64)),
            Mistake::Time { factor } => ("time", Some(*factor), None),
            Mistake::Parameter { factor, .. } => ("parameter", Some(*factor), None),
        };
        let channels = match mistake {
            Mistake::Parameter { name, .. } => vec![name.clone()],
            other => other.channels().into_iter().map(str::to_owned).collect(),
        };
        let probability = reading.probability;
        Reading { kind: kind.to_owned(), channels, factor, late, probability, is_tied }
    };
    let also = reading.also.iter().map(|mistake| of(mistake, true));
    std::iter::once(of(&reading.mistake, false)).chain(also).collect()
}

fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NoGap => "no gap",
        Verdict::Cause => "cause",
        Verdict::Tied => "tied",
        Verdict::Pair => "pair",
        Verdict::NoneOfThese => "none of these",
        Verdict::Unclear => UNCLEAR,
    }
}

fn together_with(pair: &Pair) -> Together {
    Together { causes: pair.causes.each_ref().map(named), probability: pair.probability }
}

fn named(cause: &Cause) -> Named {
    let side = match cause.side {
        Side::Input => "input",
        Side::Dynamics => "dynamics",
        Side::Output => "output",
    };
    Named {
        label: cause.label.to_owned(),
        law: cause.law.to_owned(),
        family: cause.family.to_owned(),
        side: side.to_owned(),
        site: cause.site.name().unwrap_or_default().to_owned(),
        partner: cause.partner.as_ref().and_then(|p| p.name()).map(str::to_owned),
        probability: cause.probability,
    }
}
