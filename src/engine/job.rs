//! A long piece of work that can be watched and cancelled from another thread.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::error::{Error, Result};

/// Progress and cancellation, shared between the thread that works and the one that watches.
///
/// Workers call [`Job::check`] once per row, tile or frame and pass the error on, so that cancelling is prompt.
#[derive(Debug, Default)]
pub struct Job {
    cancelled: AtomicBool,
    done: AtomicUsize,
    total: AtomicUsize,
    texts: Mutex<JobTexts>,
}

#[derive(Debug, Default)]
struct JobTexts {
    stage: String,
    context: String,
    warnings: Vec<String>,
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

    fn texts(&self) -> MutexGuard<'_, JobTexts> {
        self.texts.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Starts a stage of `total` units and forgets the progress of the one before.
    pub fn start(&self, stage: impl Into<String>, total: usize) {
        self.texts().stage = stage.into();
        self.done.store(0, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
    }

    /// Sets what the coming stages are parts of; empty text unsets it.
    pub fn set_context(&self, context: impl Into<String>) {
        self.texts().context = context.into();
    }

    /// Reports recoverable trouble in one line, each line once.
    pub fn warn(&self, warning: String) {
        let warnings = &mut self.texts().warnings;
        if !warnings.contains(&warning) {
            warnings.push(warning);
        }
    }

    /// The recoverable trouble so far, in order.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        self.texts().warnings.clone()
    }

    /// Counts `units` more of the stage as finished.
    pub fn advance(&self, units: usize) {
        self.done.fetch_add(units, Ordering::Relaxed);
    }

    /// Asks the work to stop at its next check.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether the job is cancelled.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// Gives [`Error::Cancelled`] once the job is cancelled.
    ///
    /// # Errors
    /// [`Error::Cancelled`] after [`Job::cancel`].
    pub fn check(&self) -> Result<()> {
        if self.is_cancelled() { Err(Error::Cancelled) } else { Ok(()) }
    }

    /// How far the work has come.
    #[must_use]
    pub fn progress(&self) -> Progress {
        let JobTexts { stage, context, .. } = &*self.texts();
        Progress {
            context: context.clone(),
            stage: stage.clone(),
            done: self.done.load(Ordering::Relaxed),
            total: self.total.load(Ordering::Relaxed),
        }
    }
}
