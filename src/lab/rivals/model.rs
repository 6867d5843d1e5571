//! What methods of others are made of and what they do.

use std::sync::Arc;

use overlook_engine::capture::{Camera, Frame};
use overlook_engine::median::median_by;
use overlook_engine::render::Picture;

/// A camera and what it saw at a frame.
#[derive(Clone, Debug)]
pub struct RecordedView {
    /// Where from.
    pub camera: Camera,
    /// What it saw.
    pub frame: Arc<Frame>,
}

/// What a method keeps of one frame.
pub trait RivalModel: Send + Sync {
    /// The picture at a viewpoint. [`Picture::image`] is [`NO_IMAGE`](overlook_engine::render::NO_IMAGE) in holes and 0 elsewhere.
    fn render(&self, target: &Camera) -> Picture;

    /// Bytes of the model as a file, with values rounded to 8 bits (depth to 24) and deflated; `None` if the method keeps all recorded
    /// pictures.
    fn bytes(&self) -> Option<u64>;
}

/// Middle of the finite depths of all views, and the mean width of a pixel there; `None` where no view has any.
pub(super) fn median_footprint(views: &[RecordedView]) -> Option<(f64, f64)> {
    let mut footprints: Vec<(f64, f64)> = Vec::new();
    for view in views {
        let k = view.camera.intrinsics;
        let depths = view.frame.inverse_depth.as_slice().iter().filter(|inverse_depth| **inverse_depth > 0.0);
        footprints.extend(depths.map(|inverse_depth| {
            let depth = 1.0 / f64::from(*inverse_depth);
            (depth, depth / (k.fx * k.fy).sqrt())
        }));
    }
    median_by(&mut footprints, |a, b| a.0.total_cmp(&b.0))
}

/// Length of bytes after DEFLATE (RFC 1951).
pub(super) fn deflated(bytes: &[u8]) -> u64 {
    let mut compressor = libdeflater::Compressor::new(libdeflater::CompressionLvl::default());
    let mut room = vec![0; compressor.deflate_compress_bound(bytes.len())];
    compressor.deflate_compress(bytes, &mut room).unwrap_or(bytes.len()) as u64
}
