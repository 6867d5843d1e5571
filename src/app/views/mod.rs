//! The pictures, and what is drawn over them and said about them.

mod axis_marks;
pub(super) mod cameras_view;
mod chart_parts;
pub(super) mod chart_view;
pub(super) mod colormap;
pub(super) mod compare_view;
pub(super) mod frusta;
pub(super) mod legend;
pub(super) mod live_image;
pub(super) mod live_view;
pub(super) mod marks;
pub(super) mod pixel_view;
pub(super) mod readout;
pub(super) mod rig;
pub(super) mod source_image;
pub(super) mod source_view;
pub(super) mod stability_view;
pub(super) mod words;
