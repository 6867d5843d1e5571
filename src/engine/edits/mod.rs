//! Edits by hand: a list of cameras that are left out, and of regions that are deleted, kept alone or brought back.
//!
//! ```text
//! edits.toml ─▶ EditList ┬─ before pruning: pixels in deleted regions count as pixels without depth ─▶ pruning
//!                        └─ on samples: every edit, on what pruning kept or a store holds ─▶ SampleSet + CutByHand
//! ```
//!
//! Source: none for the list; regions are combined as sets, as in constructive solid geometry. What differs from editors of splats and
//! points: a region may ask what other cameras say of a sample, and every edit has frames. Two rules say when an edit acts:
//!
//! - A region in space, in a picture, of values or of colors deletes *observations*, before pruning, so that no redundant pixel of another camera brings
//!   back what was deleted, and what a masked pixel represented is represented by others.
//! - A region that asks for evidence (votes of cameras, doubt, angle) or depends on other samples (what a picture shows, a surface, what is
//!   near) and an edit that reaches over the spans of samples act on what pruning *kept*, since only a sample has evidence and a span.
//!
//! Regions that depend on other samples are worked out once, of the samples before the list acts on them: a region holds the same whatever
//! else is in the list, and twice deletes what once does. Applied to a store that has the list behind it, they would hold what has become
//! visible; its report says so, and they do not act again.
//!
//! Once pruning is done the whole list acts on its samples, in order. So nothing is left inside of what was deleted, and a store that is
//! edited afterwards obeys the same list.

mod apply;
mod drawn_area;
mod list;
mod list_file;
mod marks;
mod region;
mod region_test;
mod removed_pixels;
mod seen;
mod tile;

pub use apply::{CutByHand, EditedImages, cut, edit_samples, edit_tinted, selected};
pub(crate) use list::refuse_nothing;
pub use list::{Action, Edit, EditList, Reach};
pub use region::{Outline, Region, Stroke, Viewpoint};
pub use removed_pixels::{count_removed_pixels, edited_capture, with_cameras_left, without_removed_pixels};
