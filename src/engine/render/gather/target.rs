//! What the gather stage writes to: rows of the picture, a block of 16×16 pixels of its z-buffer after another.

use crate::render::input::FrameSamples;
use crate::render::splat::{inverse_depth_of, slot_of};
use crate::render::vantage::{FrontColor, NO_IMAGE};
use crate::samples::TILE;

/// Columns and rows of the blocks of the z-buffer that share a list of cameras.
pub(crate) const BLOCK: usize = TILE;

/// Blocks whose colors are looked up together at most: points of many blocks fill vectors better than those of one.
pub(crate) const TOGETHER: usize = 4;

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
