//! Pruning (the paper, §3.2): of all samples of one surface point the best-sampled one stays.

mod background;
mod best_candidate;
mod coverage;
mod decision;
mod pack;
mod pass;
mod search;
mod span_stack;
mod status;

pub use background::PrunedBackground;
pub(crate) use background::{StaticLayer, rated, static_layers};
pub(crate) use best_candidate::{OtherCamera, lanes_at, rivals};
pub use decision::{Decided, Dispute, Rule, Verdict};
pub use pack::{Masks, pack};
pub(crate) use pass::{BAND_ROWS, rule_between};
pub use search::prune;
pub use span_stack::{FRAME, SpanStack, load_frame};
pub(crate) use status::UNDECIDED;
pub use status::{DROPPED, KEPT, Statuses, no_statuses};
