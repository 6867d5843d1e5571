//! What the window computes, on threads of its own.
//!
//! ```text
//! State ── Scheduler ──▶ requests ──▶ Workers (a thread each) ── Message ──▶ Outbox ──▶ window
//! ```

mod accuracy;
mod carry;
mod compare;
mod compare_place;
mod develop;
mod difference;
mod edits;
mod facts;
mod figure_meaning;
mod figures;
mod files;
mod histograms;
mod live_image;
mod live_schedule;
mod opening;
mod other_pictures;
mod pruning;
mod readings;
mod requests;
mod scheduler;
mod share_facts;
mod share_preview;
mod sharing;
mod source_comparisons;
mod source_image;
mod study;
mod worker;
mod workers;

pub(crate) use figures::{FIGURE_ENDINGS, of_camera, of_rendered, write as write_figure};
pub(crate) use files::with_ending;
pub(crate) use requests::{
    Export, ExportRequest, FigureExport, FileRequest, OpenRequest, PathExport, StudyRequest,
};
pub(crate) use scheduler::Scheduler;
pub(crate) use worker::Outbox;
pub(crate) use workers::Workers;
