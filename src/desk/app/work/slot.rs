//! Work that follows from the state alone: a request, the worker that answers it, and its last question.

use std::cell::RefCell;
use std::time::Duration;

use crate::app::model::{Message, State, WorkKind};
use crate::app::work::outbox::Outbox;
use crate::app::work::worker::{Supersede, Worker};
use overlook_engine::error::Result;
use overlook_engine::job::Job;

/// A request that a room makes as the state needs it. Equal requests have equal answers.
pub(crate) trait Wanted: Clone + PartialEq + Send + Sized + 'static {
    /// Whether the window shows what comes of it, so that it is not at rest before.
    const IS_SHOWN: bool = true;

    /// What is needed now; `None` where nothing is, and what came of the last request is kept.
    fn wanted(state: &State) -> Option<Self>;

    /// Whether the answer to it is still of use; else it is stopped, and made again where it is wanted again.
    fn is_of_use(&self, _state: &State) -> bool {
        true
    }

    /// After how long something else is needed although the state stays as it is; `None` where that is not so.
    fn changes_in(_state: &State) -> Option<Duration> {
        None
    }
}

/// A worker, and what it was asked last: nothing is asked twice.
pub(crate) struct Slot<R> {
    pub worker: Worker<R>,
    asked: RefCell<Option<R>>,
}

impl<R: Wanted> Slot<R> {
    /// Starts the worker, as [`Worker::start`].
    ///
    /// # Errors
    /// `Io` where the operating system gives no thread.
    pub(crate) fn start(
        kind: WorkKind,
        supersede: Supersede,
        outbox: &Outbox,
        work: impl FnMut(R, &Job) -> Result<Message> + Send + 'static,
    ) -> Result<Self> {
        Ok(Self { worker: Worker::start(kind, supersede, outbox, work)?, asked: RefCell::new(None) })
    }

    /// What was asked last.
    pub(crate) fn asked(&self) -> Option<R> {
        self.asked.borrow().clone()
    }

    /// What is needed and was not asked last.
    fn missing(&self, state: &State) -> Option<R> {
        R::wanted(state).filter(|wanted| self.asked.borrow().as_ref() != Some(wanted))
    }
}

/// A slot, whatever it is asked.
pub(crate) trait AnySlot {
    /// Asks for what is needed and was not asked last. Gives the time after which to call again, if any.
    fn ask(&self, state: &State) -> Option<Duration>;

    /// Stops what runs, and lets an equal request be made again.
    fn stop(&self);

    /// Lets an equal request be made again.
    fn forget(&self);

    /// Whether nothing runs or waits, nor will as long as the state stays as it is.
    fn is_at_rest(&self, state: &State) -> bool;
}

impl<R: Wanted> AnySlot for Slot<R> {
    fn ask(&self, state: &State) -> Option<Duration> {
        // Before the rest, as time passes meanwhile.
        let changes_in = R::changes_in(state);
        if self.asked.borrow().as_ref().is_some_and(|asked| !asked.is_of_use(state)) {
            self.stop();
        }
        if let Some(wanted) = self.missing(state) {
            self.worker.submit(wanted.clone());
            self.asked.replace(Some(wanted));
        }
        changes_in
    }

    fn stop(&self) {
        self.worker.cancel();
        self.forget();
    }

    fn forget(&self) {
        self.asked.replace(None);
    }

    fn is_at_rest(&self, state: &State) -> bool {
        let will_ask = || R::changes_in(state).is_some() || self.missing(state).is_some();
        self.worker.is_idle() && !(R::IS_SHOWN && will_ask())
    }
}
