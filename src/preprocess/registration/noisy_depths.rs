//! Depths that differ by more than the tolerance, but by no more than the noise of both cameras explains.

use super::reproject::{PixelRun, ReprojectedRun};
use crate::preprocess::layers::{CameraLayer, PackedGeometry};

/// By how much the noise of both cameras may move the points of a block off the surfaces that the target found: for each its
/// distance along the ray, times both inverse depths as in the [comparison](super::same_surface).
#[cold]
#[inline(never)]
pub(crate) fn granted_to_noise<const N: usize>(
    (source, block): (&CameraLayer, &PixelRun<N>),
    (target, carried, found): (&CameraLayer, &ReprojectedRun<N>, &[PackedGeometry; N]),
    sigmas: f32,
) -> [f32; N] {
    let mut granted = [0.0; N];
    for (lane, granted) in granted.iter_mut().enumerate() {
        let (w, there) = (block.inverse_depth[lane], found[lane].inverse_depth);
        if w > 0.0 && there > 0.0 {
            let pixel = block.row * source.width + block.column + lane;
            let own = source.depth_noise(pixel) * there;
            *granted = sigmas * own.hypot(target.depth_noise(carried.pixel[lane] as usize) * w);
        }
    }
    granted
}

/// The same for the samples that the target found and three of their neighbors each, which are as noisy: by corner.
#[cold]
#[inline(never)]
pub(crate) fn granted_around<const N: usize>(
    target: &CameraLayer,
    carried: &ReprojectedRun<N>,
    found: &[PackedGeometry; N],
    neighbors: &[[f32; N]; 3],
    sigmas: f32,
) -> [[f32; N]; 3] {
    let noise = carried.pixel.map(|pixel| sigmas * target.depth_noise(pixel as usize));
    neighbors.map(|depths| {
        std::array::from_fn(|lane| {
            let (here, there) = (found[lane].inverse_depth, depths[lane]);
            noise[lane] * (here * here + there * there).sqrt()
        })
    })
}
