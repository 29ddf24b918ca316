//! Work in a thread of its own, while the thread that was called shows progress and listens for Ctrl-C.

use std::{
    panic::{AssertUnwindSafe, catch_unwind, resume_unwind},
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed},
        mpsc::{RecvTimeoutError, channel},
    },
    thread,
    time::Duration,
};

use fd_gap::diagnose::{Monitor, Stage};
use pyo3::prelude::*;

/// Time between two looks.
const LOOK: Duration = Duration::from_millis(50);

/// What a diagnosis that was told to stop unwinds with, from its next sign of life up to [`run`]. Nothing of a
/// diagnosis outlives it, so nothing is left half done; and it is no panic: no message is printed.
struct Stopped;

/// How far the work is.
#[derive(Debug, Default)]
pub(crate) struct Watch {
    stopped: AtomicBool,
    stage: Mutex<(&'static str, usize)>,
    done: AtomicUsize,
}

impl Watch {
    fn look(&self) {
        if self.stopped.load(Relaxed) {
            resume_unwind(Box::new(Stopped));
        }
    }
}

impl Monitor for Watch {
    fn is_over(&self) -> bool {
        self.stopped.load(Relaxed)
    }

    fn begin(&self, stage: Stage, pieces: usize) {
        self.look();
        *self.stage.lock().unwrap_or_else(PoisonError::into_inner) = (stage.words(), pieces);
        self.done.store(0, Relaxed);
    }

    fn advance(&self) {
        self.look();
        self.done.fetch_add(1, Relaxed);
    }
}

/// Does the work without the lock of the interpreter. `progress` is called with the stage, what is done and how
/// much that is of. When a signal handler or `progress` raises an exception, `stop` is called, the work ends at
/// its next sign of life, and the exception is raised.
pub(crate) fn run<T: Send>(
    py: Python<'_>,
    progress: Option<&Py<PyAny>>,
    stop: impl Fn() + Sync,
    work: impl FnOnce(&Watch) -> T + Send,
) -> PyResult<T> {
    let watch = Watch::default();
    let done = py.detach(|| {
        thread::scope(|scope| {
            let (sender, ended) = channel();
            let watch = &watch;
            let worker = scope.spawn(move || {
                let done = catch_unwind(AssertUnwindSafe(|| work(watch)));
                // Whoever listens may be gone.
                let _ = sender.send(());
                done
            });
            let mut raised = None;
            let mut shown = ("", 0, 0);
            while let Err(RecvTimeoutError::Timeout) = ended.recv_timeout(LOOK) {
                if raised.is_none()
                    && let Err(error) = Python::attach(|py| look(py, watch, progress, &mut shown))
                {
                    watch.stopped.store(true, Relaxed);
                    stop();
                    raised = Some(error);
                }
            }
            (worker.join(), raised)
        })
    });
    match done {
        (_, Some(error)) => Err(error),
        (Ok(Ok(value)), None) => Ok(value),
        (Ok(Err(panic)) | Err(panic), None) => resume_unwind(panic),
    }
}

/// Listens for signals, and shows what is new.
fn look(
    py: Python<'_>,
    watch: &Watch,
    progress: Option<&Py<PyAny>>,
    shown: &mut (&'static str, usize, usize),
) -> PyResult<()> {
    py.check_signals()?;
    let (stage, pieces) = *watch.stage.lock().unwrap_or_else(PoisonError::into_inner);
    let now = (stage, watch.done.load(Relaxed), pieces);
    if let Some(progress) = progress.filter(|_| !stage.is_empty() && now != *shown) {
        *shown = now;
        progress.call1(py, now)?;
    }
    Ok(())
}
