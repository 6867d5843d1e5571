//! The two pictures: what a camera saw, and what is left of it seen from anywhere.

pub(super) mod colormap;
pub(super) mod frusta;
pub(super) mod legend;
pub(super) mod live_image;
pub(super) mod live_view;
pub(super) mod readout;
pub(super) mod rig;
pub(super) mod source_image;
pub(super) mod source_view;
