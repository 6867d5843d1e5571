//! What is drawn.

pub(crate) mod camera_list;
pub(crate) mod overlay;
pub(crate) mod overlays;
pub(crate) mod view;

pub(crate) use view::cameras_view_ui;
