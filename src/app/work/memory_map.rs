//! What takes the memory: bytes of the kept samples by camera.

use crate::app::model::CameraMemory;
use crate::samples::SampleSet;

/// The memory of each camera's samples, in the order of the cameras.
pub(crate) fn by_camera(samples: &SampleSet) -> Vec<CameraMemory> {
    let mut cameras = vec![CameraMemory::default(); samples.cameras.len()];
    for image in &samples.images {
        let Some(camera) = cameras.get_mut(image.camera as usize) else { continue };
        camera.samples += image.len() as u64;
        let bytes = if image.span.len() > 1 { &mut camera.lasting_bytes } else { &mut camera.frame_bytes };
        *bytes += image.bytes() as u64;
    }
    cameras
}
