//! A long piece of work that can be watched and cancelled from another thread.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use crate::error::{Error, Result};

/// Progress and cancellation, shared between the thread that works and the one that watches.
///
/// Workers call [`Job::check`] once per row, tile or frame and pass the error on, so that cancelling is prompt.
#[derive(Debug, Default)]
pub struct Job {
    cancelled: AtomicBool,
    done: AtomicUsize,
    total: AtomicUsize,
    stage: Mutex<String>,
    context: Mutex<String>,
    warnings: Mutex<Vec<String>>,
}

/// How far a [`Job`] has come.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Progress {
    /// What the stage is a part of, as in `3 of 60, 2 min left`; empty where it is all there is.
    pub context: String,
    /// What is being done, in words fit for a progress bar.
    pub stage: String,
    /// Units of the stage that are finished.
    pub done: usize,
    /// Units of the stage; 0 while unknown.
    pub total: usize,
}

impl Progress {
    /// Share of the stage that is finished, 0 to 1; 0 while the total is unknown.
    #[must_use]
    pub fn fraction(&self) -> f32 {
        if self.total == 0 { 0.0 } else { self.done as f32 / self.total as f32 }
    }
}

impl Job {
    /// A job that has not started.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Starts a stage of `total` units and forgets the progress of the one before.
    pub fn start(&self, stage: impl Into<String>, total: usize) {
        if let Ok(mut name) = self.stage.lock() {
            *name = stage.into();
        }
        self.done.store(0, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
    }

    /// Says what the coming stages are parts of; empty text takes it back.
    pub fn set_context(&self, context: impl Into<String>) {
        if let Ok(mut text) = self.context.lock() {
            *text = context.into();
        }
    }

    /// Tells of recoverable trouble, in one line; a line that was told already is not told again.
    pub fn warn(&self, warning: String) {
        if let Ok(mut warnings) = self.warnings.lock()
            && !warnings.contains(&warning)
        {
            warnings.push(warning);
        }
    }

    /// The trouble that was told, in order.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        self.warnings.lock().map(|warnings| warnings.clone()).unwrap_or_default()
    }

    /// Counts `units` more of the stage as finished.
    pub fn advance(&self, units: usize) {
        self.done.fetch_add(units, Ordering::Relaxed);
    }

    /// Asks the work to stop at its next check.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether the work was asked to stop.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// Gives [`Error::Cancelled`] once the work was asked to stop.
    ///
    /// # Errors
    /// [`Error::Cancelled`] after [`Job::cancel`].
    pub fn check(&self) -> Result<()> {
        if self.is_cancelled() { Err(Error::Cancelled) } else { Ok(()) }
    }

    /// How far the work has come.
    #[must_use]
    pub fn progress(&self) -> Progress {
        Progress {
            context: self.context.lock().map(|context| context.clone()).unwrap_or_default(),
            stage: self.stage.lock().map(|name| name.clone()).unwrap_or_default(),
            done: self.done.load(Ordering::Relaxed),
            total: self.total.load(Ordering::Relaxed),
        }
    }
}
