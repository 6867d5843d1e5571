//! The pictures, and what is drawn over and beside them.

mod cameras_overlay;
mod cameras_view;
mod chart_parts;
mod chart_view;
mod compare_view;
mod drawing;
mod edit_shapes;
mod go_to;
mod guides;
mod legend;
mod live_pixels;
mod live_view;
mod overlays;
mod pixel_view;
mod source_view;

pub(crate) use cameras_view::cameras_view_ui;
pub(crate) use chart_view::{stability_ui, tradeoff_ui};
pub(crate) use compare_view::compare_view_ui;
pub(crate) use legend::bar;
pub(crate) use live_view::{go_to_camera_ui, live_view_ui};
pub(crate) use pixel_view::pixel_view_ui;
pub(crate) use source_view::{cameras_ui, source_view_ui};
