//! Progress bars on stderr.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::job::Job;

const REDRAW: Duration = Duration::from_millis(100);

/// Sets the flag when the work ends, in whatever way.
struct SetOnDrop<'a>(&'a AtomicBool);

impl Drop for SetOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

/// Does `work` under a progress bar, where stderr is a terminal that can show one.
pub(super) fn watched<T>(work: impl FnOnce(&Job) -> T) -> T {
    let job = Job::new();
    if !std::io::stderr().is_terminal() {
        return work(&job);
    }
    let finished = AtomicBool::new(false);
    thread::scope(|scope| {
        let watcher =
            thread::Builder::new().name("progress".to_owned()).spawn_scoped(scope, || draw(&job, &finished));
        let result = {
            let _finish = SetOnDrop(&finished);
            work(&job)
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
