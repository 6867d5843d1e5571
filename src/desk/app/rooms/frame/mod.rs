//! What surrounds the views: bars, workspaces and notices.

pub(crate) mod control;
pub(crate) mod model;
pub(crate) mod ui;
