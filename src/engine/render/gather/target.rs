//! What the gather stage writes to: rows of the picture, a block of 16×16 pixels of its z-buffer after another.

use std::sync::{Mutex, MutexGuard, PoisonError};

use super::block::GatherScratch;
use crate::render::input::FrameSamples;
use crate::render::splat::{inverse_depth_of, slot_of};
use crate::render::vantage::{FrontColor, NO_IMAGE};
use crate::samples::TILE;

/// Columns and rows of the blocks of the z-buffer that share a list of cameras.
pub(crate) const BLOCK: usize = TILE;

/// Column and row of the first pixel of a block, in the z-buffer.
#[derive(Clone, Copy)]
pub(crate) struct BlockOrigin {
    pub(crate) left: usize,
    pub(crate) top: usize,
}

/// A row of blocks: the rows of the three planes of a picture that it covers.
pub(crate) struct PictureRows<'a> {
    /// Columns of the picture.
    pub(crate) width: usize,
    /// Pixels of the z-buffer along each side of a pixel of the picture: 1 or 2.
    pub(crate) subpixels: usize,
    pub(crate) color: &'a mut [[f32; 3]],
    pub(crate) inverse_depth: &'a mut [f32],
    pub(crate) image: &'a mut [u32],
    /// Empty unless it is wanted.
    pub(crate) fronts: &'a mut [FrontColor],
    /// As in a picture; empty unless pixels have sub-pixels.
    pub(crate) coverage: &'a mut [f32],
}

impl PictureRows<'_> {
    /// Columns and rows of a block that are in the picture, in pixels of the z-buffer.
    #[inline(always)]
    pub(crate) fn extent(&self, left: usize) -> (usize, usize) {
        (BLOCK.min(self.width * self.subpixels - left), self.image.len() / self.width * self.subpixels)
    }

    /// Sets a pixel, given by its position in these rows, to the sample of a key, or to a hole where the key is 0.
    #[inline(always)]
    pub(crate) fn set(&mut self, frame: &FrameSamples<'_>, at: usize, key: u64, color: [f32; 3]) {
        self.color[at] = color;
        self.inverse_depth[at] = inverse_depth_of(key);
        self.image[at] = if key == 0 { NO_IMAGE } else { frame.image_of(slot_of(key)) };
    }
}

/// Sets the images of pixels that show the samples of some keys. Gives the cameras of these samples.
#[inline(always)]
pub(super) fn set_images<const N: usize>(
    keys: &[u64; N],
    frame: &FrameSamples<'_>,
    images: &mut [u32],
) -> [u16; N] {
    let mut cameras = [0; N];
    for ((key, camera), image) in keys.iter().zip(&mut cameras).zip(images) {
        (*camera, *image) = (frame.camera_of(slot_of(*key)), frame.image_of(slot_of(*key)));
    }
    cameras
}

/// Scratch memory that no thread uses.
#[derive(Debug, Default)]
pub(crate) struct ScratchPool(Mutex<Vec<GatherScratch>>);

/// Scratch memory that returns to its pool when it is dropped.
pub(crate) struct PooledScratch<'a> {
    scratch: Option<GatherScratch>,
    pool: &'a ScratchPool,
}

impl ScratchPool {
    /// Empties the tile caches, for another frame or vantage.
    pub(crate) fn forget(&self) {
        self.idle().iter_mut().for_each(GatherScratch::forget);
    }

    /// The nanoseconds that threads have spent on silhouettes and on look-ups since the last call.
    pub(crate) fn take_spent(&self) -> [u64; 2] {
        let mut all = [0, 0];
        for scratch in self.idle().iter_mut() {
            let spent = std::mem::take(&mut scratch.spent_ns);
            (0..2).for_each(|nth| all[nth] += spent[nth]);
        }
        all
    }

    /// Scratch memory for this many cameras.
    pub(crate) fn borrow(&self, cameras: usize) -> PooledScratch<'_> {
        let scratch = self.idle().pop().filter(|scratch| scratch.camera_count() == cameras);
        PooledScratch { scratch, pool: self }
    }

    fn idle(&self) -> MutexGuard<'_, Vec<GatherScratch>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl PooledScratch<'_> {
    /// The scratch memory; allocated on the first call if the pool had none.
    pub(crate) fn get(&mut self, cameras: usize) -> &mut GatherScratch {
        self.scratch.get_or_insert_with(|| GatherScratch::new(cameras))
    }
}

impl Drop for PooledScratch<'_> {
    fn drop(&mut self) {
        self.pool.idle().extend(self.scratch.take());
    }
}
