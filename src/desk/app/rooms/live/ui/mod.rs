//! What is drawn.

pub(crate) mod go_to;
pub(crate) mod guides;
mod kept_views;
pub(crate) mod live_pixels;
pub(crate) mod view;
pub(crate) mod view_panel;

pub(crate) use kept_views::view_picture_ui;
pub(crate) use view::{go_to_camera_ui, live_view_ui};
pub(crate) use view_panel::view_panel_ui;
