//! Long calls: other Python threads run on, progress is reported, and Ctrl-C stops the work.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use super::exceptions::to_exception;
use overlook_engine::error::Result;
use overlook_engine::job::{Job, Progress};

/// Time between two checks for signals and reports of progress.
const EVERY: Duration = Duration::from_millis(50);

/// Wakes the waiting thread when the work ends, even by a panic.
struct Wake<'a>(&'a AtomicBool, thread::Thread);

impl Drop for Wake<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
        self.1.unpark();
    }
}

/// Does `work` on a thread of its own. `progress` is called with the stage, the units done and their total.
///
/// # Errors
/// What `work` gives; what `progress` raises, and `KeyboardInterrupt`, once the work has stopped.
pub(super) fn run<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Job) -> Result<T> + Send,
) -> PyResult<T> {
    let (job, finished) = (Job::new(), AtomicBool::new(false));
    let waiting = thread::current();
    thread::scope(|scope| {
        let worker = scope.spawn(|| {
            let _wake = Wake(&finished, waiting);
            work(&job)
        });
        let mut raised = None;
        let mut reported = Progress::default();
        while !finished.load(Ordering::Acquire) {
            py.detach(|| thread::park_timeout(EVERY));
            if raised.is_none()
                && let Err(error) = py.check_signals().and_then(|()| report(progress, &job, &mut reported))
            {
                job.cancel();
                raised = Some(error);
            }
        }
        let result = worker.join();
        match (raised, result) {
            (Some(error), _) => Err(error),
            (None, Ok(result)) => result.map_err(|error| to_exception(&error)),
            (None, Err(_)) => Err(PyRuntimeError::new_err("the engine failed; its message is on stderr")),
        }
    })
}

/// Reports the progress if it differs from the last report.
fn report(progress: Option<&Bound<'_, PyAny>>, job: &Job, reported: &mut Progress) -> PyResult<()> {
    let Some(progress) = progress else { return Ok(()) };
    let now = job.progress();
    if now != *reported {
        progress.call1((now.stage.clone(), now.done, now.total))?;
        *reported = now;
    }
    Ok(())
}
