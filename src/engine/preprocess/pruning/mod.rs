//! Pruning (the paper, §3.2): of all samples of one surface point the best-sampled one stays. The rules are in `decision.rs`.
//!
//! ```text
//! background (static layers, once) ─▶ span stack (ever shorter spans) ─▶ search: best candidate ─▶ coverage ─▶ pack
//! ```

mod background;
mod best_candidate;
mod coverage;
mod decision;
mod find_best;
mod pack;
mod pass;
mod search;
mod span_stack;

pub(crate) use background::{PrunedBackground, StaticLayer, rated, static_layer, static_layers};
pub(crate) use best_candidate::{OtherCamera, lanes_at, other_cameras};
pub(crate) use coverage::{Waiting, settle};
pub(crate) use decision::{
    Candidate, LevelVerdicts, decide, is_better, is_dropped_as_mixed, may_be_witness, rule_of_dropped,
    rule_of_kept,
};
pub use decision::{Rule, Verdict};
pub(crate) use pack::Masks;
pub use pack::pack;
pub use pass::no_statuses;
pub(crate) use pass::{ABSENT, BAND_ROWS, DROPPED, KEPT, PruningPass, Statuses, UNDECIDED};
pub use search::prune;
pub(crate) use search::{find, pass_over_views};
pub use span_stack::FRAME;
pub(crate) use span_stack::{SpanStack, StackStep, load_frame};
