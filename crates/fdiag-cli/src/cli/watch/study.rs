//! `fdiag gap` on a stretch of recent samples, in a process of its own with a time limit.

use std::{
    fmt::Write as _,
    fs::{self, File},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    sync::{
        Arc, Mutex, PoisonError,
        mpsc::{Receiver, SyncSender, TrySendError, sync_channel},
    },
    time::{Duration, Instant},
};

use fd_watch::{Event, What};

use super::nightly::Stretch;

/// How often a running study is looked at.
const LOOK: Duration = Duration::from_millis(100);

/// A thread that lets one stretch after another be studied. Who hands a stretch over never waits.
pub(super) struct Studies {
    stretches: SyncSender<Stretch>,
    answers: Receiver<Event>,
    running: Running,
}

/// The process of the present study.
type Running = Arc<Mutex<Option<Child>>>;

/// What a study needs besides the samples.
#[derive(Clone)]
pub(super) struct StudyPlan {
    /// Model file that is studied.
    pub model: PathBuf,
    /// Longest time of a study.
    pub longest: Duration,
    /// First line of a log: time, then the channels with their units.
    pub header: String,
}

impl Studies {
    /// Starts the thread.
    pub(super) fn start(plan: StudyPlan) -> Self {
        // One waits while one is studied; what comes meanwhile will have grown again another night.
        let (stretches, next) = sync_channel::<Stretch>(1);
        let (answer, answers) = sync_channel(8);
        let running = Running::default();
        let present = Arc::clone(&running);
        std::thread::spawn(move || {
            for stretch in next {
                let samples = stretch.rows.len() / plan.header.split(',').count().max(1);
                let tell = |what| Event {
                    unit: Some(stretch.unit.clone()),
                    time: Some(stretch.time),
                    what,
                };
                if answer.send(tell(What::GapStudyStarted { samples: samples as u64 })).is_err() {
                    return;
                }
                let what = match study(&plan, &stretch, &present) {
                    Ok(headline) => What::GapStudied { answer: headline },
                    Err(reason) => What::GapStudyFailed { reason },
                };
                if answer.send(tell(what)).is_err() {
                    return;
                }
            }
        });
        Self { stretches, answers, running }
    }

    /// Hands a stretch over; an event when nothing can be made of it now.
    pub(super) fn take(&self, stretch: Stretch) -> Option<Event> {
        let (TrySendError::Full(stretch) | TrySendError::Disconnected(stretch)) =
            self.stretches.try_send(stretch).err()?;
        let reason = "other units are being studied".to_owned();
        let what = What::GapStudyFailed { reason };
        Some(Event { unit: Some(stretch.unit), time: Some(stretch.time), what })
    }

    /// What has been answered since it was last asked.
    pub(super) fn answers(&self) -> impl Iterator<Item = Event> {
        self.answers.try_iter()
    }
}

/// A study ends with its monitor.
impl Drop for Studies {
    fn drop(&mut self) {
        let mut running = self.running.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(child) = &mut *running {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

fn study(plan: &StudyPlan, stretch: &Stretch, running: &Running) -> Result<String, String> {
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let log = folder.path().join("recent.csv");
    fs::write(&log, text(&plan.header, &stretch.rows)).map_err(|error| error.to_string())?;
    let (said, wrong) = (folder.path().join("said"), folder.path().join("wrong"));
    let file = |path: &Path| File::create(path).map_err(|error| error.to_string());
    let program = std::env::current_exe().map_err(|error| error.to_string())?;
    // It comes after everything else on the machine, where the system has a word for that.
    let mut command = if cfg!(unix) { Command::new("nice") } else { Command::new(&program) };
    if cfg!(unix) {
        command.args(["-n", "19"]).arg(&program);
    }
    let child = command
        .args(["gap", "--no-programs", "--json", "--threads", "1", "--drop-disorder", "--model"])
        .arg(&plan.model)
        .arg("--log")
        .arg(&log)
        .arg("--out")
        .arg(folder.path().join("report"))
        .stdin(Stdio::null())
        .stdout(file(&said)?)
        .stderr(file(&wrong)?)
        .spawn()
        .map_err(|error| error.to_string())?;
    *running.lock().unwrap_or_else(PoisonError::into_inner) = Some(child);
    let begun = Instant::now();
    let status = loop {
        let mut present = running.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(child) = &mut *present else { return Err("it has gone".to_owned()) };
        if let Some(status) = child.try_wait().map_err(|error| error.to_string())? {
            *present = None;
            break status;
        }
        if plan.longest < begun.elapsed() {
            let _ = child.kill();
            let _ = child.wait();
            *present = None;
            return Err(format!("it took longer than {} s", plan.longest.as_secs_f64()));
        }
        drop(present);
        std::thread::sleep(LOOK);
    };
    let read = |path| fs::read_to_string(path).map_err(|error| error.to_string());
    if !status.success() {
        let wrong = read(wrong)?;
        return Err(wrong.trim().chars().take(500).collect());
    }
    let report: serde_json::Value =
        serde_json::from_str(&read(said)?).map_err(|error| error.to_string())?;
    let headline = report.get("headline").and_then(serde_json::Value::as_str);
    headline.map(str::to_owned).ok_or_else(|| "the report has no headline".to_owned())
}

/// Rows as a log; what was not measured is an empty cell.
fn text(header: &str, rows: &[f64]) -> String {
    let mut text = format!("{header}\n");
    for row in rows.chunks_exact(header.split(',').count().max(1)) {
        for (column, value) in row.iter().enumerate() {
            let comma = if column == 0 { "" } else { "," };
            // Writing to a text does not fail.
            let _ = if value.is_nan() {
                write!(text, "{comma}")
            } else {
                write!(text, "{comma}{value}")
            };
        }
        text.push('\n');
    }
    text
}
