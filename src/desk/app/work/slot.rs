//! Work that follows from the state alone: a request, the worker that answers it, and its last question.

use crate::app::model::{Message, State, WorkKind};
use crate::app::rooms::frame::model::DockView;
use crate::app::work::outbox::Outbox;
use crate::app::work::worker::{Supersede, Worker};
use overlook_engine::error::Result;
use overlook_engine::job::Job;

/// A request that a room makes as the state and the visible views need it. Equal requests have equal answers.
pub(crate) trait Wanted: Clone + PartialEq + Send + Sized + 'static {
    /// What is needed now; `None` where nothing is, and what came of the last request is kept.
    fn wanted(state: &State, visible: &[DockView]) -> Option<Self>;

    /// Whether the last request is forgotten, so that an equal one is made again.
    fn is_forgotten(_state: &State) -> bool {
        false
    }
}

/// A worker, and what it was asked last: nothing is asked twice.
pub(crate) struct Slot<R> {
    pub worker: Worker<R>,
    asked: Option<R>,
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
        Ok(Self { worker: Worker::start(kind, supersede, outbox, work)?, asked: None })
    }

    /// What was asked last.
    pub(crate) fn asked(&self) -> Option<&R> {
        self.asked.as_ref()
    }
}

/// A slot, whatever it is asked.
pub(crate) trait AnySlot {
    /// Asks for what is needed and was not asked last.
    fn ask(&mut self, state: &State, visible: &[DockView]);

    /// Lets an equal request be made again.
    fn forget(&mut self);

    /// Whether nothing runs or waits.
    fn is_idle(&self) -> bool;
}

impl<R: Wanted> AnySlot for Slot<R> {
    fn ask(&mut self, state: &State, visible: &[DockView]) {
        if R::is_forgotten(state) {
            self.asked = None;
        }
        let wanted = R::wanted(state, visible).filter(|wanted| self.asked.as_ref() != Some(wanted));
        if let Some(wanted) = wanted {
            self.worker.submit(wanted.clone());
            self.asked = Some(wanted);
        }
    }

    fn forget(&mut self) {
        self.asked = None;
    }

    fn is_idle(&self) -> bool {
        self.worker.is_idle()
    }
}
