//! Pruning (the paper, §3.2): of all samples of one surface point the best-sampled one stays. The rules are in `decision.rs`.
//!
//! ```text
//! background (static layers, once), then ever shorter spans ─▶ search: best candidate ─▶ coverage ─▶ pack
//! ```

mod best_candidate;
mod coverage;
mod decision;
mod find_best;
mod pack;
mod pass;
mod search;
mod span_stack;

pub(crate) use best_candidate::{ColumnBounds, OtherCamera, lanes_at, other_cameras};
pub(crate) use coverage::{Prepared, Preparing, Resolved, Unsettled, resolve_camera, settle_all};
pub(crate) use decision::{
    Candidate, LevelVerdicts, decide, is_better, is_dropped_as_mixed, may_be_witness, rule_of_dropped,
    rule_of_kept,
};
pub use decision::{Rule, Verdict};
pub(crate) use pack::Masks;
pub use pack::pack;
pub(crate) use pass::{
    ABSENT, DROPPED, KEPT, PruningPass, Statuses, UNDECIDED, all_may_be_witnesses, mark_undecided,
    no_statuses,
};
pub(crate) use search::{BAND_ROWS, Search, ask_others, conclude_all, find, left_open, look_at_own, prune};
pub use span_stack::FRAME;
pub(crate) use span_stack::{
    SpanSource, SpanStack, StaticLayer, load_frame, measure_others_noise, rated, static_layer, static_layers,
};
