//! What the window computes, on threads of its own.
//!
//! ```text
//! State ── Wanted (what is missing) ──▶ Slots ──▶ Workers (a thread each) ── Message ──▶ Outbox ──▶ window
//! ```

pub(crate) mod outbox;
pub(crate) mod requests;
pub(crate) mod slot;
pub(crate) mod worker;
pub(crate) mod workers;

pub(crate) use outbox::{Outbox, Unread};
pub(crate) use requests::{
    Export, ExportRequest, FigureExport, FileRequest, OpenRequest, PathExport, StudyRequest,
};
pub(crate) use workers::Workers;
