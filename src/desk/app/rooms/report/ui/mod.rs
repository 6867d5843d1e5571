//! What is drawn.

pub(crate) mod alignment;
pub(crate) mod causes;
pub(crate) mod matrix;
pub(crate) mod memory_view;
pub(crate) mod pair_grid;
pub(crate) mod panel;
pub(crate) mod totals;

pub(crate) use memory_view::memory_ui;
pub(crate) use panel::{matrix_view_ui, report_ui};
pub(crate) use totals::totals_ui;
