//! Facts about every camera: its picture with what was pruned dimmed, and the memory of its samples.

use std::sync::Arc;

use egui::ColorImage;

use crate::app::colormap::{dimmed, recorded};
use crate::app::model::CameraMemory;
use crate::preprocess::inspect::{CameraInspection, FrameInspection};
use crate::samples::SampleSet;

/// Largest side of a thumbnail, pixels.
const SIDE: usize = 256;

/// How bright pruned pixels are.
const DIMMED: f32 = 0.45;

/// One picture per camera, in the capture's order.
pub(crate) fn thumbnails(inspection: &FrameInspection) -> Vec<Arc<ColorImage>> {
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

/// The memory of each camera's samples, in the order of the cameras.
pub(crate) fn memory(samples: &SampleSet) -> Vec<CameraMemory> {
    let mut cameras = vec![CameraMemory::default(); samples.cameras.len()];
    for image in &samples.images {
        let Some(camera) = cameras.get_mut(image.camera as usize) else { continue };
        camera.samples += image.len() as u64;
        let bytes = if image.span.len() > 1 { &mut camera.lasting_bytes } else { &mut camera.frame_bytes };
        *bytes += image.bytes() as u64;
    }
    cameras
}
