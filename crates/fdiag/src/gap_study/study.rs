//! From files to an answer.

use fd_gap::diagnose::Monitor;
use fd_sim::{
    outside::{Counts, OutsideError},
    simulate::{Nominal, Simulator},
};

use super::{
    attempt::Attempt,
    error::GapError,
    findings::findings,
    follow::follow,
    found::{Found, Search, Shelf},
    further::{Asked, Further},
    headline::headline,
    law::law,
    patched::patched_models,
    pause::Pause,
    read::read_logs,
    report::{Inputs, REPORT_VERSION, Report, StudySettings, Timing, first_cause},
    request::{HorizonChoice, Request},
    subject::Subject,
    traces::{Trace, trace},
    words,
};

/// A diagnosis with everything that its report needs.
#[derive(Clone, Debug)]
pub struct GapStudy {
    /// The report as data.
    pub report: Report,
    /// Signals for pictures.
    pub trace: Option<Trace>,
    /// What was asked of a simulator outside of this program, and what went wrong last with it.
    pub outside: Option<(Counts, Option<OutsideError>)>,
}

impl GapStudy {
    /// Reads, diagnoses, locates, advises. What takes long tells `monitor` how far it is.
    ///
    /// ```no_run
    /// use fdiag::gap_study::{GapStudy, Request};
    ///
    /// let study = GapStudy::run(&Request::new("cart.toml", ["monday.csv"]), &())?;
    /// println!("{}", study.report.headline);
    /// # Ok::<(), fdiag::gap_study::GapError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns the first file, setting or step that is wrong.
    pub fn run(request: &Request, monitor: &dyn Monitor) -> Result<Self, GapError> {
        Self::run_on(request, &Subject::of(request)?, monitor)
    }

    /// The same with a subject that is there: the model file of the request is but its name.
    ///
    /// # Errors
    ///
    /// Returns the first log, setting or step that is wrong.
    pub fn run_on(
        request: &Request,
        subject: &Subject,
        monitor: &dyn Monitor,
    ) -> Result<Self, GapError> {
        let workers = subject.outside().map_or(1, Simulator::workers);
        let study = on_threads(workers, || Self::of(request, subject, monitor));
        let mut study = study.map_err(|e| subject.explained(e))?;
        study.outside =
            subject.outside().map(|simulator| (simulator.counts(), simulator.trouble()));
        Ok(study)
    }

    fn of(request: &Request, subject: &Subject, monitor: &dyn Monitor) -> Result<Self, GapError> {
        let mut data = read_logs(request, subject, None)?;
        subject.check_cost(&data.fit, &request.limits)?;
        let of_simulator = subject.unrepeated(&data)?;
        // Who states a horizon wants that, and no filter.
        let is_auto = request.horizon == HorizonChoice::Auto;
        let follower = if is_auto { follow(subject.nominal(), &data.fit)? } else { None };
        let nominal: &dyn Nominal = match &follower {
            Some(follower) => {
                data.follow(follower);
                follower
            }
            None => subject.nominal(),
        };
        let pause = Pause::of(monitor);
        let shelf = Shelf::default();
        let search = Search { request, subject, nominal, data: &data, follower: follower.as_ref() };
        let Found { attempt, reading, whole } = search.find(&shelf, &pause, monitor)?;
        let asked = Asked { request, is_followed: follower.is_some(), pause: &pause };
        let further = Further::of(&attempt, asked, monitor)?;
        let Further { road, location, ceiling, advice, calibration } = further;
        let Attempt { subject, nominal, data, logs, memory, settings, ts, .. } = attempt;
        let (diagnosis, sparing) = (attempt.diagnosis, attempt.sparing);
        // What knows the slopes of these logs answers further questions with fewer runs.
        let nominal: &dyn Nominal = sparing.as_ref().map_or(nominal, |(_, lent)| lent);
        let (model, [fitted, _]) = (subject.model(), &logs);
        let law = first_cause(&diagnosis)
            .and_then(|cause| law(nominal, &diagnosis, cause, &location, fitted, ts));
        let models = patched_models(subject, &diagnosis, road.as_ref(), data);
        let mut report = Report {
            version: REPORT_VERSION,
            headline: String::new(),
            reading,
            next: Vec::new(),
            road,
            law,
            ceiling,
            advice,
            calibration,
            findings: findings(&diagnosis, data, model, of_simulator),
            whole,
            time_limit: pause.time_limit(),
            stopped: pause.left_out(&diagnosis),
            sparing: sparing.as_ref().map(|(sparing, _)| sparing.clone()),
            inputs: Inputs::of(request, model, data, memory),
            settings: StudySettings::of(request, &settings, ts.seconds(), follower.is_some()),
            models,
            timing: Timing::default(),
            diagnosis,
            location,
        };
        report.headline = headline(&report);
        report.next = words::next_steps(&report);
        let trace = trace(nominal, &report, data, &logs, ts);
        Ok(Self { report, trace, outside: None })
    }
}

/// Most threads for the instances of a simulator.
const MOST_THREADS: usize = 64;

/// Works on as many threads as a simulator has instances, where that is more than there are: most of them wait.
pub(super) fn on_threads<T: Send>(workers: usize, act: impl FnOnce() -> T + Send) -> T {
    let threads = workers.min(MOST_THREADS);
    if threads <= rayon::current_num_threads() {
        return act();
    }
    match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(act),
        // Fewer instances are then at work.
        Err(_) => act(),
    }
}
