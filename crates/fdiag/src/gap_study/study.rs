//! From files to an answer.

use fd_gap::{
    diagnose::{Beginning, Monitor, Settings},
    fit::{FitError, Horizon, Log},
    quality::{Defect, Finding},
};
use fd_model::{Record, SampleTime};
use fd_sim::{
    outside::{Counts, OutsideError},
    simulate::{Nominal, Simulator},
};

use super::{
    attempt::Attempt,
    data::Data,
    error::GapError,
    findings::findings,
    follow::follow,
    found::{Found, Search, Shelf},
    further::{Asked, Further},
    headline::headline,
    law::law,
    memory::Memory,
    patched::patched_models,
    pause::Pause,
    report::{Inputs, REPORT_VERSION, Report, StudySettings, Timing},
    request::{HorizonChoice, Request, StartsChoice},
    subject::Subject,
    traces::{Trace, trace},
    words,
};

/// Horizons of automatic windows, in memories of the model.
const WINDOWS: [f64; 2] = [1.0, 5.0];
/// Fewest samples of a window.
const SHORTEST_WINDOW: usize = 20;
/// Windows in the shortest log.
const FEWEST_WINDOWS: usize = 3;
/// A log that lasts for less than this part of the memory of the model is short.
const LEAST_OF_MEMORY: f64 = 1.0 / 3.0;

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
        let mut data = Data::read(request, subject, None)?;
        subject.check_cost(&data, &request.limits)?;
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
        let law = law(nominal, &diagnosis, &location, fitted, ts);
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

/// Inputs of the longest log, row by row, and its samples.
pub(super) fn longest(logs: &[Log]) -> (Vec<f64>, usize) {
    let longest = logs.iter().max_by_key(|log| log.samples());
    longest.map_or_else(Default::default, |log| {
        let rows = (0..log.samples()).flat_map(|k| log.input(k).iter().copied());
        (rows.collect(), log.samples())
    })
}

/// A log that ends before the initial state is forgotten says more of that than of the plant; or the model has
/// something in another unit.
pub(super) fn short_log(data: &Data, memory: Memory, ts: SampleTime) -> Option<Finding> {
    let numbered = data.fit.iter().enumerate();
    let (log, record) = numbered.max_by_key(|(_, record)| record.len())?;
    let (seconds, memory) = (record.len() as f64 * ts.seconds(), memory.slowest?);
    let channel = record.outputs().first()?.name.clone();
    let defect = Defect::Short { seconds, memory };
    let is_short = data.long.is_none() && seconds < LEAST_OF_MEMORY * memory;
    is_short.then_some(Finding { log: log + 1, channel, defect })
}

/// The settings that a diagnosis chooses by itself, with all defaults, for one log to fit and one to
/// hold out.
///
/// # Errors
///
/// Returns an error when the model cannot be simulated or the logs do not fit it.
pub fn automatic_settings(nominal: &dyn Nominal, logs: &[Record; 2]) -> Result<Settings, FitError> {
    let ts = logs[0].ts();
    let simulator = nominal.simulator(ts)?;
    let [fitted, held_out] =
        [Log::new(&logs[0], &*simulator, 1)?, Log::new(&logs[1], &*simulator, 2)?];
    let logs = [vec![fitted], vec![held_out]];
    let (u, samples) = longest(&logs[0]);
    let memory = Memory::of(&*simulator, &u, samples);
    let request = Request::new("", Vec::<std::path::PathBuf>::new());
    Ok(settings(&request, memory, &logs, ts))
}

pub(super) fn settings(
    request: &Request,
    memory: Memory,
    logs: &[Vec<Log>; 2],
    ts: SampleTime,
) -> Settings {
    let shortest = logs.iter().flatten().map(Log::samples).min().unwrap_or(0);
    let windows = |seconds: f64| {
        let most = (shortest / FEWEST_WINDOWS).max(SHORTEST_WINDOW);
        Horizon::Windows { samples: samples(seconds, ts).clamp(SHORTEST_WINDOW, most) }
    };
    let horizon = match (request.horizon, memory) {
        // Windows throw away what is slow, and what lags and delays remember; they are for plants that
        // run away from any start. A free run that is lost otherwise is noticed by the diagnosis.
        (HorizonChoice::Free, _) | (HorizonChoice::Auto, Memory { runs_away: false, .. }) => {
            Horizon::FreeRun
        }
        (HorizonChoice::Seconds(seconds), _) => {
            Horizon::Windows { samples: samples(seconds, ts).max(2) }
        }
        (HorizonChoice::Auto, Memory { seconds, .. }) => {
            let tenth = 0.1 * shortest as f64 * ts.seconds();
            windows(seconds.map_or(tenth, |seconds| WINDOWS[1] * seconds))
        }
    };
    let mut report_horizons = vec![horizon];
    let others = memory.seconds.into_iter().flat_map(|s| WINDOWS.map(|n| windows(n * s)));
    for other in std::iter::once(Horizon::FreeRun).chain(others) {
        if !report_horizons.contains(&other) {
            report_horizons.push(other);
        }
    }
    let beginning = match request.starts {
        StartsChoice::Either => Beginning::Either,
        StartsChoice::Stated => Beginning::AsStated,
        StartsChoice::Free => Beginning::InMotion,
    };
    let Request { seed, controller_sees, .. } = *request;
    Settings { horizon, report_horizons, seed, beginning, controller_sees, ..Settings::default() }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
fn samples(seconds: f64, ts: SampleTime) -> usize {
    (seconds / ts.seconds()).round() as usize
}
