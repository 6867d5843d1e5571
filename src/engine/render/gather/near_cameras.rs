//! Which cameras can tell something of a pixel: those whose samples are seen around it.
//!
//! ```text
//!     a a a b b b c        a, b, c: cameras that the z-buffer shows. Of the pixel p only a and b are asked, although the block shows
//!     a a p b b c c        samples of c too
//!     a a a b b c c
//! ```
//!
//! Purpose: with many cameras a block of pixels shows samples of many, but each pixel those of few. In a pruned set a camera of which none
//! is seen around a pixel kept none of that surface there, and its look-up would find nothing.
//!
//! Source: none; the z-buffer is its own index of who kept what.

use super::silhouette::{Patch, RING, SIDE};
use super::target::BLOCK;
use super::view_weights::SourceViews;
use crate::render::input::FrameSamples;
use crate::render::splat::slot_of;

/// Where a block shows samples of so few cameras, all are asked: it costs less than to find out which.
const FEW: usize = 4;

/// The last bit of a mask of cameras stands for all from this rank on.
const LAST_BIT: usize = 31;

/// The bit of a camera in the masks of a block, by its place in the block's list.
#[inline(always)]
pub(super) fn bit_of(rank: usize) -> u32 {
    1 << rank.min(LAST_BIT)
}

/// Which of the listed cameras recorded the surface at inverse depth `w` in pixel `(x, y)` so coarsely that their samples count farther away
/// than a block's ring reaches: from a sample to the end of its footprint is half of a recorded pixel.
#[inline(always)]
pub(super) fn coarse_cameras(views: &SourceViews<'_>, at: (f32, f32), w: f32, cameras: &[u16]) -> u32 {
    let mut mask = 0;
    for (rank, &camera) in cameras.iter().enumerate() {
        if views.is_coarser(camera, at, w, 2.0 * RING as f32) {
            mask |= bit_of(rank);
        }
    }
    mask
}

/// Lists the cameras that recorded the samples of some z-buffer keys, ascending.
#[inline(always)]
pub(super) fn list_cameras(keys: &[u64], frame: &FrameSamples<'_>, cameras: &mut Vec<u16>) {
    cameras.clear();
    let is_few = frame.set.cameras.len() <= 64;
    // Most neighbors are of the same tile.
    let (mut tile, mut seen) = (u32::MAX, 0_u64);
    for &key in keys {
        let slot = slot_of(key);
        if key == 0 || slot >> 8 == tile {
            continue;
        }
        tile = slot >> 8;
        let camera = frame.camera_of(slot);
        if is_few {
            seen |= 1 << (camera % 64);
        } else {
            cameras.push(camera);
        }
    }
    cameras.sort_unstable();
    cameras.dedup();
    while seen != 0 {
        cameras.push(seen.trailing_zeros() as u16);
        seen &= seen - 1;
    }
}

/// Masks of cameras for the pixels of a block.
#[derive(Debug)]
pub(super) struct NearCameras {
    /// The bit of each camera; only those of the block's list are of this block.
    bits: Vec<u32>,
    masks: [[u32; BLOCK]; BLOCK],
}

impl NearCameras {
    /// For this many cameras.
    pub(super) fn new(cameras: usize) -> Self {
        Self { bits: vec![0; cameras], masks: [[u32::MAX; BLOCK]; BLOCK] }
    }

    /// Whether it is worth finding which of a block's cameras are seen around each pixel.
    pub(super) fn pay_off(cameras: &[u16]) -> bool {
        cameras.len() > FEW
    }

    /// All cameras for all pixels.
    #[inline(always)]
    pub(super) fn set_all(&mut self) {
        self.masks = [[u32::MAX; BLOCK]; BLOCK];
    }

    /// Those of the listed cameras of which a sample is seen within [`RING`] pixels of each pixel of the z-buffer, or of one that shares its
    /// pixel of the picture; `always` for every pixel.
    #[inline(always)]
    pub(super) fn find(&mut self, patch: &Patch, frame: &FrameSamples<'_>, cameras: &[u16], always: u32) {
        for (rank, camera) in cameras.iter().enumerate() {
            self.bits[*camera as usize] = bit_of(rank);
        }
        let mut along = [[0_u32; BLOCK]; SIDE];
        for (keys, along) in patch.keys.iter().zip(&mut along) {
            let mut seen = [0; SIDE];
            for x in 0..SIDE {
                if keys[x] != 0 {
                    seen[x] = self.bits[frame.camera_of(slot_of(keys[x])) as usize];
                }
            }
            for x in 0..BLOCK {
                along[x] = seen[x..=x + 2 * RING].iter().fold(0, |all, bits| all | bits);
            }
        }
        for (y, masks) in self.masks.iter_mut().enumerate() {
            *masks = [always; BLOCK];
            for along in &along[y..=y + 2 * RING] {
                for x in 0..BLOCK {
                    masks[x] |= along[x];
                }
            }
        }
        if patch.subpixels == 2 {
            for [above, below] in self.masks.as_chunks_mut::<2>().0 {
                for x in (0..BLOCK).step_by(2) {
                    above[x] |= above[x + 1] | below[x] | below[x + 1];
                }
            }
        }
    }

    /// The mask of a pixel of the block. Where pixels of the picture have sub-pixels, that of the first of them is that of all.
    #[inline(always)]
    pub(super) fn mask(&self, column: usize, row: usize) -> u32 {
        self.masks[row][column]
    }

    /// The masks of a row, one of every `step` columns.
    #[inline(always)]
    pub(super) fn row<const N: usize>(&self, row: usize, step: usize) -> [u32; N] {
        let mut masks = [0; N];
        for i in 0..N {
            masks[i] = self.masks[row][i * step];
        }
        masks
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::DemoSpec;
    use crate::render::splat::{CORE, key, nearness};
    use crate::render::tests::scene;

    #[test]
    fn a_camera_is_near_a_pixel_where_a_sample_of_it_is_seen_within_the_ring() {
        let (samples, _) = scene(DemoSpec::new("orrery").cameras(8).size((64, 48)), 1);
        let frame = FrameSamples::at(&samples, 1).unwrap();
        let mut patch = Patch::empty();
        let mut number = 7_usize;
        for key_of_pixel in patch.keys.as_flattened_mut() {
            number = number * 1_103_515_245 % 2_147_483_647;
            let tile = number / 64 % frame.tile_count();
            // Two of three pixels are holes, so that not every camera is near every pixel.
            *key_of_pixel =
                if number.is_multiple_of(3) { key(nearness(1.0, CORE), (tile as u32) << 8) } else { 0 };
        }
        let mut cameras = Vec::new();
        list_cameras(patch.keys.as_flattened(), &frame, &mut cameras);
        assert!(cameras.len() > FEW && NearCameras::pay_off(&cameras));
        cameras.reverse();
        let always = bit_of(2);
        let mut near = NearCameras::new(samples.cameras.len());
        for subpixels in [1, 2] {
            patch.subpixels = subpixels;
            near.find(&patch, &frame, &cameras, always);
            for row in (0..BLOCK).step_by(subpixels) {
                for column in (0..BLOCK).step_by(subpixels) {
                    let mut expected = always;
                    for keys in &patch.keys[row..row + 2 * RING + subpixels] {
                        for key in keys[column..column + 2 * RING + subpixels].iter().filter(|key| **key != 0)
                        {
                            let camera = frame.camera_of(slot_of(*key));
                            expected |= bit_of(cameras.iter().position(|listed| *listed == camera).unwrap());
                        }
                    }
                    assert_eq!(near.mask(column, row), expected, "{column}, {row}");
                }
            }
        }
        assert_eq!((bit_of(0), bit_of(31), bit_of(900)), (1, 1 << 31, 1 << 31));
    }
}
