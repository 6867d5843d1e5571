//! Workers: one named thread each, one kind of work each. The latest request for a picture wins; files wait in line.
//!
//! ```text
//! UI ── submit(request) ──▶ slot (what waits: one, or a line) ──▶ thread ── Message ──▶ bounded channel ──▶ logic()
//!                     └──▶ Job::cancel of the request it supersedes
//! ```
//!
//! A panic in a job becomes an error message; the worker and the window live on.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::app::model::{Message, State, WorkKind};
use overlook_engine::error::{Error, Result};
use overlook_engine::job::{Job, Progress};

/// What happens to the job that runs when a newer request of its kind arrives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Supersede {
    /// It is cancelled.
    Always,
    /// It is cancelled unless the one before it was: under a stream of requests, as from a slider in motion or from time that
    /// passes, every second job that is begun still arrives.
    Alternate,
    /// It finishes, as it takes no longer than a picture on the screen does.
    Never,
    /// It finishes, and so does all that waits: every file that was requested is written.
    Queue,
}

struct LatestRequest<R> {
    /// The next first; more than one only where requests queue.
    waiting: VecDeque<(R, Arc<Job>)>,
    running: Option<Arc<Job>>,
    /// Whether the running request was cancelled for a newer one.
    is_superseded: bool,
    /// Whether the request before it was.
    last_was_superseded: bool,
    closed: bool,
}

impl<R> LatestRequest<R> {
    /// What runs, or is next.
    fn now(&self) -> Option<&Arc<Job>> {
        self.running.as_ref().or_else(|| self.waiting.front().map(|(_, job)| job))
    }
}

/// What a worker's thread and the window share: the requests that wait, and the signal that one arrived.
struct RequestSlot<R> {
    slot: Mutex<LatestRequest<R>>,
    arrived: Condvar,
}

impl<R> RequestSlot<R> {
    fn lock(&self) -> MutexGuard<'_, LatestRequest<R>> {
        // Nothing that changes the slot can panic halfway, so that it is whole even after a panic elsewhere.
        self.slot.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A named thread that does one kind of work, one request at a time.
pub(crate) struct Worker<R> {
    shared: Arc<RequestSlot<R>>,
    supersede: Supersede,
}

impl<R: Send + 'static> Worker<R> {
    /// Starts the thread. `work` turns a request into the message that answers it; `kind` names it in errors.
    ///
    /// # Errors
    /// `Io` where the operating system gives no thread.
    pub(crate) fn start(
        kind: WorkKind,
        supersede: Supersede,
        outbox: &Outbox,
        mut work: impl FnMut(R, &Job) -> Result<Message> + Send + 'static,
    ) -> Result<Self> {
        let slot = LatestRequest {
            waiting: VecDeque::new(),
            running: None,
            is_superseded: false,
            last_was_superseded: false,
            closed: false,
        };
        let shared = Arc::new(RequestSlot { slot: Mutex::new(slot), arrived: Condvar::new() });
        let (inbox, outbox) = (shared.clone(), outbox.clone());
        // Nobody waits for the thread: it ends at its job's next check, and waiting would hold the closing window open.
        std::thread::Builder::new()
            .name(format!("{kind:?}"))
            .spawn(move || {
                while let Some((request, job)) = next(&inbox) {
                    let answer = run(kind, &mut work, request, &job);
                    outbox.announce();
                    inbox.lock().running = None;
                    if !outbox.deliver(answer) {
                        break;
                    }
                }
            })
            .map_err(|error| Error::io(format!("thread '{kind:?}'"), error))?;
        Ok(Self { shared, supersede })
    }

    /// Submits a request: behind those that wait where requests queue, else in their place.
    pub(crate) fn submit(&self, request: R) {
        let mut slot = self.shared.lock();
        if let Some(job) = slot.running.clone() {
            let cancels = match self.supersede {
                Supersede::Always => true,
                Supersede::Alternate => !slot.last_was_superseded,
                Supersede::Never | Supersede::Queue => false,
            };
            slot.is_superseded |= cancels;
            if cancels {
                job.cancel();
            }
        }
        if self.supersede != Supersede::Queue {
            slot.waiting.clear();
        }
        slot.waiting.push_back((request, Arc::new(Job::new())));
        drop(slot);
        self.shared.arrived.notify_one();
    }
}

impl<R> Worker<R> {
    /// Cancels the running request, or the next one. Waiting requests are dropped unless requests queue.
    pub(crate) fn cancel(&self) {
        let mut slot = self.shared.lock();
        if self.supersede != Supersede::Queue {
            slot.waiting.clear();
        }
        if let Some(job) = slot.now() {
            job.cancel();
        }
    }

    /// Progress of the running work; `None` while none runs.
    pub(crate) fn progress(&self) -> Option<Progress> {
        self.shared.lock().now().map(|job| job.progress())
    }

    /// Whether nothing runs or waits.
    pub(crate) fn is_idle(&self) -> bool {
        self.progress().is_none()
    }
}

impl<R> Drop for Worker<R> {
    fn drop(&mut self) {
        self.cancel();
        let mut slot = self.shared.lock();
        slot.waiting.clear();
        slot.closed = true;
        drop(slot);
        self.shared.arrived.notify_one();
    }
}

fn next<R>(shared: &RequestSlot<R>) -> Option<(R, Arc<Job>)> {
    let mut slot = shared.lock();
    loop {
        if slot.closed {
            return None;
        }
        if let Some((request, job)) = slot.waiting.pop_front() {
            slot.running = Some(job.clone());
            slot.last_was_superseded = std::mem::take(&mut slot.is_superseded);
            return Some((request, job));
        }
        slot = shared.arrived.wait(slot).unwrap_or_else(PoisonError::into_inner);
    }
}

fn run<R>(
    kind: WorkKind,
    work: &mut impl FnMut(R, &Job) -> Result<Message>,
    request: R,
    job: &Job,
) -> Message {
    // A job that panicked leaves at worst a stale cache behind, which the next request replaces.
    let error = match catch_unwind(AssertUnwindSafe(|| work(request, job))) {
        Ok(Ok(message)) => return message,
        // The error of a cancelled job is of no use.
        Ok(Err(_)) if job.is_cancelled() => Error::Cancelled,
        Ok(Err(error)) => error,
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let reason = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no reason given");
            let text = format!("{reason}; your files are untouched, please report it");
            Error::invalid("a fault in Overlook", text)
        }
    };
    Message::Failed { work: kind, error }
}

/// Where workers report to: the channel to the window, and the window's bell.
#[derive(Clone)]
pub(crate) struct Outbox {
    sender: SyncSender<Message>,
    ctx: egui::Context,
    pub unread: Unread,
}

/// Messages that the window has not taken in. They count from before their worker rests, so that never both look idle in between.
#[derive(Clone, Default)]
pub(crate) struct Unread(Arc<AtomicUsize>);

impl Unread {
    pub(crate) fn is_none(&self) -> bool {
        self.0.load(Ordering::SeqCst) == 0
    }

    /// One was taken in.
    pub(crate) fn read_one(&self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

impl Outbox {
    /// An outbox that rings `ctx` after every message.
    pub(crate) fn new(sender: SyncSender<Message>, ctx: egui::Context) -> Self {
        Self { sender, ctx, unread: Unread::default() }
    }

    /// Delivers a message; gives false once the window is gone.
    pub(crate) fn send(&self, message: Message) -> bool {
        self.announce();
        self.deliver(message)
    }

    /// Says that a message follows.
    pub(super) fn announce(&self) {
        self.unread.0.fetch_add(1, Ordering::SeqCst);
    }

    /// Delivers a message that was announced; gives false once the window is gone.
    pub(super) fn deliver(&self, message: Message) -> bool {
        let delivered = self.sender.send(message).is_ok();
        self.ctx.request_repaint();
        delivered
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicU32;
    use std::sync::mpsc::{Receiver, sync_channel};

    fn worker(
        supersede: Supersede,
        work: impl FnMut(u32, &Job) -> Result<Message> + Send + 'static,
    ) -> (Worker<u32>, Receiver<Message>) {
        let (sender, receiver) = sync_channel(16);
        let outbox = Outbox::new(sender, egui::Context::default());
        (Worker::start(WorkKind::File, supersede, &outbox, work).unwrap(), receiver)
    }

    fn saved(number: u32) -> Message {
        Message::Saved { path: "x".into(), bytes: Some(u64::from(number)), holds: None }
    }

    fn received(receiver: &Receiver<Message>) -> Message {
        receiver.recv_timeout(Duration::from_secs(20)).unwrap()
    }

    /// The number of the request that is answered next.
    fn answered(receiver: &Receiver<Message>) -> u64 {
        let Message::Saved { bytes: Some(number), .. } = received(receiver) else { panic!("no answer") };
        number
    }

    fn wait_for_start(worker: &Worker<u32>) {
        while worker.shared.lock().running.is_none() {
            std::thread::yield_now();
        }
    }

    /// Work whose first request only ends when it is cancelled.
    fn endless_at_first(number: u32, job: &Job) -> Result<Message> {
        if number > 1 {
            return Ok(saved(number));
        }
        loop {
            job.check()?;
            std::thread::yield_now();
        }
    }

    #[test]
    fn the_latest_request_wins_and_the_running_one_is_cancelled() {
        let (worker, receiver) = worker(Supersede::Always, endless_at_first);
        worker.submit(1);
        wait_for_start(&worker);
        worker.submit(2);
        assert!(matches!(received(&receiver), Message::Failed { error: Error::Cancelled, .. }));
        assert_eq!(answered(&receiver), 2);
    }

    #[test]
    fn however_fast_requests_come_every_second_job_that_is_begun_arrives_and_nothing_after_the_last() {
        let done = Arc::new(AtomicU32::new(0));
        let may_end = done.clone();
        let (worker, receiver) = worker(Supersede::Alternate, move |number, job| {
            while may_end.load(Ordering::Relaxed) < number {
                job.check()?;
                std::thread::yield_now();
            }
            Ok(saved(number))
        });
        let wait_for_job = || {
            while !worker.shared.lock().waiting.is_empty() {
                std::thread::yield_now();
            }
        };
        let mut number = 0;
        for _ in 0..3 {
            worker.submit(number + 1);
            wait_for_job();
            worker.submit(number + 2);
            assert!(matches!(received(&receiver), Message::Failed { error: Error::Cancelled, .. }));
            wait_for_job();
            (number + 3..number + 6).for_each(|number| worker.submit(number));
            done.store(number + 2, Ordering::Relaxed);
            assert_eq!(answered(&receiver), u64::from(number + 2));
            done.store(number + 5, Ordering::Relaxed);
            assert_eq!(answered(&receiver), u64::from(number + 5), "those between gave way to the last");
            number += 5;
        }
        while !worker.is_idle() {
            std::thread::yield_now();
        }
        assert!(receiver.try_recv().is_err(), "something came after the last answer");
    }

    #[test]
    fn what_queues_is_all_done_in_turn_and_cancelling_ends_only_what_runs() {
        let (worker, receiver) = worker(Supersede::Queue, endless_at_first);
        (1..4).for_each(|number| worker.submit(number));
        wait_for_start(&worker);
        worker.cancel();
        assert!(matches!(received(&receiver), Message::Failed { error: Error::Cancelled, .. }));
        assert_eq!([answered(&receiver), answered(&receiver)], [2, 3]);
    }

    #[test]
    fn a_panic_becomes_a_message_and_the_lane_goes_on() {
        let (worker, receiver) = worker(Supersede::Never, |number, _| {
            assert!(number != 1, "on purpose");
            Ok(saved(number))
        });
        worker.submit(1);
        let Message::Failed { error, .. } = received(&receiver) else { panic!("no failure") };
        assert!(error.to_string().contains("on purpose"), "{error}");
        worker.submit(3);
        assert_eq!(answered(&receiver), 3);
    }
}
