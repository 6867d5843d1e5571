//! What the window computes, on threads of its own.
//!
//! ```text
//! State ── Wanted (what is missing) ──▶ Slots ──▶ Workers (a thread each) ── Message ──▶ Outbox ──▶ window
//! ```

pub(crate) mod develop;
pub(crate) mod differing_samples;
pub(crate) mod requests;
pub(crate) mod shown_samples;
pub(crate) mod worker;
pub(crate) mod workers;

pub(crate) use crate::app::work::worker::{Outbox, Unread};
pub(crate) use requests::{FileWork, OpenRequest, StudyRequest};
pub(crate) use workers::Workers;
