//! How workers answer: messages to the window, and how many of them it has not taken in.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::SyncSender;

use crate::app::model::Message;

/// Where workers report to: the channel to the window, and the window's bell.
#[derive(Clone)]
pub(crate) struct Outbox {
    sender: SyncSender<Message>,
    ctx: egui::Context,
    unread: Unread,
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

    fn add_one(&self) {
        self.0.fetch_add(1, Ordering::SeqCst);
    }
}

impl Outbox {
    /// An outbox that rings `ctx` after every message.
    pub(crate) fn new(sender: SyncSender<Message>, ctx: egui::Context) -> Self {
        Self { sender, ctx, unread: Unread::default() }
    }

    /// How many messages it sent that were not taken in.
    pub(crate) fn unread(&self) -> Unread {
        self.unread.clone()
    }

    /// Delivers a message; gives false once the window is gone.
    pub(crate) fn send(&self, message: Message) -> bool {
        self.announce();
        self.deliver(message)
    }

    /// Says that a message follows.
    pub(super) fn announce(&self) {
        self.unread.add_one();
    }

    /// Delivers a message that was announced; gives false once the window is gone.
    pub(super) fn deliver(&self, message: Message) -> bool {
        let delivered = self.sender.send(message).is_ok();
        self.ctx.request_repaint();
        delivered
    }
}
