//! One picture of one camera: color, inverse depth and, where given, normals and scalar values.

use std::sync::Arc;

use half::f16;
use quick_cache::Weighter;
use quick_cache::sync::Cache;

use super::values::Values;
use crate::error::Result;
use crate::grid::Grid;

/// Inverse depth of a pixel that has no depth at all. Every negative value means the same.
pub const INVALID_INVERSE_DEPTH: f32 = -1.0;

/// One frame of one camera, in the program's own conventions whatever the file said.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Linear Rec.709, scene referred, as the capture gives it. Finite.
    pub color: Grid<[f16; 3]>,
    /// Reciprocal of planar z, 1/unit. 0 is a sample at infinity (sky); negative is a pixel without depth, which
    /// takes part in nothing. Never NaN, never infinite.
    pub inverse_depth: Grid<f32>,
    /// Unit normals in world space, toward the camera; `[0, 0, 0]` for no normal. `None` where the capture
    /// gives no normals.
    pub normal_in_world: Option<Grid<[f32; 3]>>,
    /// Relative quantization step of the depth as recorded (2⁻¹¹ for half floats, 0 where it is exact to `f32`).
    pub depth_step_relative: f32,
    /// Scalar values of every pixel, row-major, one for each of the capture's channels; empty where it has none.
    pub values: Values,
}

impl Frame {
    /// `(width, height)` in pixels.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        self.inverse_depth.size()
    }

    /// Pixels without depth.
    #[must_use]
    pub fn invalid_pixels(&self) -> usize {
        self.inverse_depth.as_slice().iter().filter(|w| **w < 0.0).count()
    }

    /// Bytes this frame occupies in memory.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let normals = if self.normal_in_world.is_some() { 12 } else { 0 };
        self.inverse_depth.len() * (6 + 4 + normals) + self.values.bytes()
    }
}

/// `(camera, frame)`, as the source counts them.
pub(super) type CameraFrame = (usize, usize);

#[derive(Clone)]
struct FrameBytes;

impl Weighter<CameraFrame, Arc<Frame>> for FrameBytes {
    fn weight(&self, _key: &CameraFrame, frame: &Arc<Frame>) -> u64 {
        frame.bytes() as u64
    }
}

/// Decoded frames, least valuable first out, never more than the given number of bytes.
///
/// No thread waits for another: a frame that two threads request at once may be decoded twice, with equal results. Waiting could
/// deadlock, since the first thread may need the second one to go on (work that is split over a thread pool while it loads).
pub(crate) struct FrameCache {
    cache: Cache<CameraFrame, Arc<Frame>, FrameBytes>,
}

/// The number of entries that a cache of large values is sized for. Beyond it the cache would be split into shards, more with more
/// processors, and a shard's share of the bytes may be less than one value takes.
pub(crate) const EXPECTED_IN_ONE_PIECE: usize = 32;

impl FrameCache {
    /// A cache that holds at most `capacity_bytes` of decoded frames.
    pub(crate) fn new(capacity_bytes: usize) -> Self {
        Self { cache: Cache::with_weighter(EXPECTED_IN_ONE_PIECE, capacity_bytes as u64, FrameBytes) }
    }

    /// Lets go of all frames.
    pub(super) fn clear(&self) {
        self.cache.clear();
    }

    /// The frame from the cache, or decoded by `load` and kept where it fits.
    ///
    /// # Errors
    /// Whatever `load` gives; errors are not cached, so that a mended file is read again.
    pub(crate) fn get_or_load(
        &self,
        key: CameraFrame,
        load: impl FnOnce() -> Result<Frame>,
    ) -> Result<Arc<Frame>> {
        if let Some(frame) = self.cache.get(&key) {
            return Ok(frame);
        }
        let frame = Arc::new(load()?);
        self.cache.insert(key, frame.clone());
        Ok(frame)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;

    fn frame(pixels: usize) -> Frame {
        Frame {
            color: Grid::filled(pixels, 1, [f16::ZERO; 3]),
            inverse_depth: Grid::filled(pixels, 1, 1.0),
            normal_in_world: None,
            depth_step_relative: 0.0,
            values: Values::default(),
        }
    }

    #[test]
    fn the_cache_never_holds_more_than_it_may() {
        let cache = FrameCache::new(100_000);
        for number in 0..100 {
            cache.get_or_load((0, number), || Ok(frame(1000))).unwrap();
            assert!(cache.cache.weight() <= 100_000);
        }
    }

    #[test]
    fn two_frames_that_take_nearly_half_of_the_cache_each_are_both_kept() {
        let cache = FrameCache::new(100_000);
        for number in [0, 1, 0, 1] {
            cache.get_or_load((0, number), || Ok(frame(4500))).unwrap();
        }
        for number in [0, 1] {
            cache.get_or_load((0, number), || Err(crate::error::Error::Cancelled)).unwrap();
        }
    }

    #[test]
    fn an_error_is_not_remembered() {
        let cache = FrameCache::new(100_000);
        assert!(cache.get_or_load((0, 0), || Err(crate::error::Error::Cancelled)).is_err());
        assert!(cache.get_or_load((0, 0), || Ok(frame(10))).is_ok());
    }

    #[test]
    fn loading_that_splits_its_work_over_the_pool_ends_however_many_ask_for_the_frame() {
        let cache = FrameCache::new(1 << 20);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        let split = |key| {
            cache.get_or_load(key, || {
                let rows: Vec<u64> =
                    (0..64).into_par_iter().map(|i| (0..2000).fold(i, u64::wrapping_mul)).collect();
                Ok(frame(rows.len()))
            })
        };
        pool.install(|| {
            (0..64).into_par_iter().for_each(|i| assert_eq!(split((0, i % 3)).unwrap().size(), (64, 1)));
        });
    }
}
