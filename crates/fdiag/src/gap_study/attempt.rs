//! A diagnosis of logs as they are read, and as they may be meant.

use fd_effect::{Candidate, EverySite, Suspects};
use fd_gap::{
    diagnose::{Case, Diagnosis, Monitor, Settings},
    fit::{FitError, Log},
    inside::inside,
    quality::{Defect, Finding},
    reading::{Mistake, Reading, Suspicion, glance, suspect},
    road::{Bounds, CauseList, road},
};
use fd_model::SampleTime;
use fd_sim::{
    scales::ReplayScales,
    simulate::{Nominal, Shell},
};

use super::{
    automatic::{longest, settings, short_log},
    data::Data,
    error::GapError,
    memory::Memory,
    only::Chosen,
    read::read_logs,
    request::Request,
    sparing::{Spared, Sparing, diagnose_sparing},
    subject::Subject,
};

/// A diagnosis with what it was made of.
pub(super) struct Attempt<'a> {
    pub subject: &'a Subject,
    /// The simulator of the subject, or one that follows the logs with it.
    pub nominal: &'a dyn Nominal,
    pub data: &'a Data,
    pub suspects: Chosen<'a>,
    pub logs: [Vec<Log>; 2],
    pub memory: Memory,
    pub settings: Settings,
    pub ts: SampleTime,
    pub diagnosis: Diagnosis,
    /// How a simulator outside was diagnosed with few runs, and what answers further questions.
    pub sparing: Option<(Sparing, Shell)>,
}

impl<'a> Attempt<'a> {
    /// Diagnoses data with a subject.
    pub(super) fn new(
        request: &Request,
        subject: &'a Subject,
        nominal: &'a dyn Nominal,
        data: &'a Data,
        monitor: &dyn Monitor,
    ) -> Result<Self, GapError> {
        let ground = Ground::new(Places::Around, request, subject, nominal, data)?;
        let (scales, settings) = (&ground.scales, &ground.settings);
        let spared = diagnose_sparing(request, subject, scales, &ground.case(), settings, monitor)?;
        Ok(ground.with(spared))
    }

    /// What answers further questions: with fewer runs where the slopes of these logs are known.
    pub(super) fn nominal(&self) -> &dyn Nominal {
        self.sparing.as_ref().map_or(self.nominal, |(_, lent)| lent)
    }

    /// What further questions are asked of.
    pub(super) fn case(&self) -> Case<'_> {
        let Data { fit, held_out, .. } = self.data;
        Case { nominal: self.nominal(), suspects: &self.suspects, logs: fit, held_out }
    }

    /// Several causes together, where one is not all there is to say.
    pub(super) fn road(
        &self,
        request: &Request,
        monitor: &dyn Monitor,
    ) -> Result<Option<CauseList>, FitError> {
        let bounds = Bounds { most: request.most, is_dear: self.sparing.is_some() };
        let case = &self.diagnosis.as_diagnosed(&self.case());
        road(case, &self.diagnosis, &self.settings, bounds, monitor)
    }

    /// The diagnosis with effects on signals inside the model as well, if that is to be reported instead of one of what
    /// is around it. `subject` has names for these signals.
    pub(super) fn inside(
        request: &Request,
        subject: &'a Subject,
        around: &Self,
        monitor: &dyn Monitor,
    ) -> Option<Self> {
        let (nominal, data) = (subject.nominal(), around.data);
        let ground = Ground::new(Places::Inside, request, subject, nominal, data).ok()?;
        let settings = &ground.settings;
        let diagnosis = inside(&ground.case(), &around.diagnosis, settings, monitor).ok()??;
        Some(ground.with(Spared { diagnosis, sparing: None }))
    }
}

/// What a diagnosis is made of.
struct Ground<'a> {
    subject: &'a Subject,
    nominal: &'a dyn Nominal,
    data: &'a Data,
    scales: ReplayScales,
    suspects: Chosen<'a>,
    logs: [Vec<Log>; 2],
    memory: Memory,
    settings: Settings,
    ts: SampleTime,
}

/// Where effects are tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Places {
    /// Inputs, states, sites, parameters and outputs.
    Around,
    /// These, and every signal inside the model.
    Inside,
}

impl<'a> Ground<'a> {
    fn new(
        places: Places,
        request: &Request,
        subject: &'a Subject,
        nominal: &'a dyn Nominal,
        data: &'a Data,
    ) -> Result<Self, GapError> {
        let model = subject.model();
        let ts = data.ts().ok_or(FitError::NoLog)?;
        let simulator = nominal.simulator(ts)?;
        let logs = data.logs(&*simulator)?;
        let (u, samples) = longest(&logs[0]);
        subject.show(&logs, ts)?;
        let memory = Memory::of(&*simulator, &u, samples);
        let settings = settings(request, memory, &logs, ts);
        let scales = nominal.scales(ts, &u, samples)?;
        let scales = match places {
            Places::Around => scales,
            Places::Inside => scales.with_signals(model, ts, &u, samples)?,
        };
        let mut effects = subject.effects();
        for own in &request.effects {
            own.check(model)?;
            effects.push(Box::new(own.clone()));
        }
        let every = EverySite::new(effects, model, scales.clone());
        // Where runs are counted only a few causes are confirmed, and what is alike would take the places of others.
        let every = if subject.outside().is_some() { every.one_by_one() } else { every };
        let suspects = Chosen::new(every, model, &request.exclude, &request.only)?;
        Ok(Self { subject, nominal, data, scales, suspects, logs, memory, settings, ts })
    }

    fn case(&self) -> Case<'_> {
        let Self { nominal, suspects, data, .. } = self;
        Case { nominal: *nominal, suspects, logs: &data.fit, held_out: &data.held_out }
    }

    fn with(self, spared: Spared) -> Attempt<'a> {
        let Self { subject, nominal, data, suspects, logs, memory, settings, ts, .. } = self;
        let Spared { mut diagnosis, sparing } = spared;
        let is_short = |finding: &Finding| matches!(finding.defect, Defect::Short { .. });
        if !diagnosis.findings.iter().any(is_short) {
            diagnosis.findings.extend(short_log(data, memory, ts));
        }
        Attempt { subject, nominal, data, suspects, logs, memory, settings, ts, diagnosis, sparing }
    }
}

/// A suspected mistake of reading, with the data, and if need be the subject, in which it is mended.
pub(super) struct Mended {
    subject: Option<Subject>,
    data: Data,
    suspicion: Suspicion,
}

/// The data with a mistake of reading mended, if one is suspected and that can be done.
pub(super) fn mended(
    request: &Request,
    subject: &Subject,
    data: &Data,
    as_read: &Result<Attempt<'_>, GapError>,
) -> Option<Mended> {
    let horizon = match as_read {
        Ok(attempt) => attempt.settings.horizon,
        // The simulation as read is lost; what is mended may not be.
        Err(GapError::Fit(_) | GapError::Simulate(_)) => Settings::default().horizon,
        Err(_) => return None,
    };
    if request.as_read {
        return None;
    }
    // No cause is tried here; what a delay among them can do is no clock.
    let none: Vec<Candidate> = Vec::new();
    let suspects: &dyn Suspects =
        as_read.as_ref().map_or(&none, |attempt| &attempt.suspects as &dyn Suspects);
    let nominal = as_read.as_ref().map_or(subject.nominal(), Attempt::nominal);
    let logs = &data.fit[..];
    let case = Case { nominal, suspects, logs, held_out: &[] };
    let diagnosis = as_read.as_ref().ok().map(|attempt| &attempt.diagnosis);
    let case = diagnosis.map_or(case, |diagnosis| diagnosis.as_diagnosed(&case));
    Mended::of(request, subject, suspect(&case, horizon, diagnosis).ok()??)
}

/// The data with a mistake of reading mended that is seen before any cause is tried; runs of simulators outside are too
/// dear for that.
pub(super) fn glanced(request: &Request, subject: &Subject, data: &Data) -> Option<Mended> {
    if request.as_read || subject.outside().is_some() {
        return None;
    }
    let suspects: Vec<Candidate> = Vec::new();
    let (nominal, logs) = (subject.nominal(), &data.fit[..]);
    let case = Case { nominal, suspects: &suspects, logs, held_out: &[] };
    Mended::of(request, subject, glance(&case, Settings::default().horizon).ok()??)
}

impl Mended {
    fn of(request: &Request, subject: &Subject, suspicion: Suspicion) -> Option<Self> {
        let mistake = suspicion.mistake();
        let other = subject.mended(mistake);
        if matches!(mistake, Mistake::Parameter { .. }) && other.is_none() {
            return None;
        }
        let data = read_logs(request, other.as_ref().unwrap_or(subject), Some(mistake)).ok()?;
        Some(Self { subject: other, data, suspicion })
    }
}

/// The diagnosis of the mended data, if that confirms the mistake.
pub(super) fn confirmed<'a>(
    request: &Request,
    subject: &'a Subject,
    mended: Option<&'a Mended>,
    monitor: &dyn Monitor,
) -> Option<(Attempt<'a>, Reading)> {
    let Mended { subject: other, data, suspicion } = mended?;
    let subject = other.as_ref().unwrap_or(subject);
    let attempt = Attempt::new(request, subject, subject.nominal(), data, monitor).ok()?;
    let reading = suspicion.clone().judged(&attempt.case(), &attempt.diagnosis)?;
    Some((attempt, reading))
}
