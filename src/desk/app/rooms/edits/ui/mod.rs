//! What is drawn.

pub(crate) mod drawing;
mod numbers;
pub(crate) mod panel;
pub(crate) mod shapes;
pub(crate) mod tools;

pub(crate) use panel::edits_ui;
