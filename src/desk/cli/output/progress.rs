//! Progress bars on stderr, and the end of work that is stopped from outside.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, Once, PoisonError};
use std::thread;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::command_error::CommandError;
use super::text;
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::store::playback::Playback;

const REDRAW: Duration = Duration::from_millis(100);

/// Calls a function when it is dropped, also in a panic.
struct OnDrop<F: FnMut()>(F);

impl<F: FnMut()> Drop for OnDrop<F> {
    fn drop(&mut self) {
        (self.0)();
    }
}

/// Exit code of a program that was stopped.
pub(crate) const STOPPED: u8 = 130;

/// The work under way.
static CURRENT: Mutex<Option<Arc<Job>>> = Mutex::new(None);

fn set_current(job: Option<Arc<Job>>) -> Option<Arc<Job>> {
    let mut current = CURRENT.lock().unwrap_or_else(PoisonError::into_inner);
    std::mem::replace(&mut *current, job)
}

/// Makes Ctrl-C (on Unix also SIGTERM and SIGHUP) cancel the current work, which then cleans up; a second one ends the program at
/// once.
fn cancel_on_signal() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let handler = || {
            let current = CURRENT.lock().unwrap_or_else(PoisonError::into_inner);
            match current.as_ref().filter(|job| !job.is_cancelled()) {
                Some(job) => job.cancel(),
                None => std::process::exit(i32::from(STOPPED)),
            }
        };
        if let Err(error) = ctrlc::set_handler(handler) {
            log::warn!("Ctrl-C will end the program at once: {error}");
        }
    });
}

/// Runs `work` with a progress bar if stderr is a terminal, and prints its warnings. Ctrl-C cancels its job.
pub(crate) fn watched<T>(work: impl FnOnce(&Job) -> T) -> T {
    cancel_on_signal();
    let job = Arc::new(Job::new());
    let mut before = set_current(Some(job.clone()));
    let _restore = OnDrop(|| drop(set_current(before.take())));
    let result = if std::io::stderr().is_terminal() { drawn(&job, work) } else { work(&job) };
    text::warn(&job.warnings());
    result
}

/// Writes something of stores, says why another renderer than that of the settings was used and what could not be read, and prints what
/// was written. `work` gives that and the notice of the renderer. `form` is what was written where it holds no scalar values.
pub(crate) fn export(
    stores: &[Arc<Playback>],
    form: Option<&str>,
    work: impl FnOnce(&Job) -> Result<(String, Option<String>)>,
) -> Result<(), CommandError> {
    let (said, notice) = watched(work)?;
    text::warn(notice.as_slice());
    for playback in stores {
        text::warn(&playback.store().damage());
        if let Some(form) = form {
            text::warn_of_values(&playback.outline().values, form);
        }
    }
    text::print(&said)
}

/// Runs `work` while its progress is drawn.
fn drawn<T>(job: &Job, work: impl FnOnce(&Job) -> T) -> T {
    let finished = AtomicBool::new(false);
    thread::scope(|scope| {
        let watcher =
            thread::Builder::new().name("progress".to_owned()).spawn_scoped(scope, || draw(job, &finished));
        let result = {
            let _finish = OnDrop(|| finished.store(true, Ordering::Release));
            work(job)
        };
        if let Ok(watcher) = watcher {
            watcher.thread().unpark();
        }
        result
    })
}

fn draw(job: &Job, finished: &AtomicBool) {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template("{msg} {bar:40} {pos}/{len}") {
        bar.set_style(style);
    }
    while !finished.load(Ordering::Acquire) {
        let progress = job.progress();
        bar.set_length(progress.total as u64);
        bar.set_position(progress.done as u64);
        let separator = if progress.context.is_empty() { "" } else { ": " };
        bar.set_message(format!("{}{separator}{}", progress.context, progress.stage));
        thread::park_timeout(REDRAW);
    }
    bar.finish_and_clear();
}
