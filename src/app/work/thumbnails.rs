//! Every camera small: its picture with what was pruned dimmed.

use std::sync::Arc;

use egui::ColorImage;

use crate::app::colormap::{dimmed, recorded};
use crate::preprocess::inspect::{CameraInspection, FrameInspection};

/// Largest side of a thumbnail, pixels.
const SIDE: usize = 256;

/// How bright pruned pixels are.
const DIMMED: f32 = 0.45;

/// One picture per camera, in the capture's order.
pub(crate) fn paint(inspection: &FrameInspection) -> Vec<Arc<ColorImage>> {
    inspection.cameras.iter().map(|camera| Arc::new(thumbnail(camera))).collect()
}

fn thumbnail(camera: &CameraInspection) -> ColorImage {
    let (width, height) = camera.verdict.size();
    let step = width.max(height).div_ceil(SIDE).max(1);
    let size = [width.div_ceil(step), height.div_ceil(step)];
    let mut pixels = Vec::with_capacity(size[0] * size[1]);
    for y in (0..height).step_by(step) {
        for x in (0..width).step_by(step) {
            let own = recorded(camera.frame.color[(x, y)]);
            pixels.push(if camera.verdict[(x, y)].is_kept() { own } else { dimmed(own, DIMMED) });
        }
    }
    ColorImage::new(size, pixels)
}
